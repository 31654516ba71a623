"use strict";
(() => {
  const root = document.documentElement;
  const errors = [];
  window.addEventListener("error", (e) => errors.push(String(e.message)));
  window.addEventListener("unhandledrejection", (e) => errors.push(String(e.reason)));
  for (const b of document.querySelectorAll(".buttons")) b.hidden = false;
  const dark = () =>
    root.dataset.theme ? root.dataset.theme === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
  document.getElementById("theme").addEventListener("click", () => {
    root.dataset.theme = dark() ? "light" : "dark";
    root.dispatchEvent(new CustomEvent("theme"));
  });
  document.getElementById("print").addEventListener("click", () => window.print());
  window.amcheck = { dark, errors, report: () => JSON.parse(document.getElementById("report-json").textContent) };
  root.dataset.ready = "page";
})();
