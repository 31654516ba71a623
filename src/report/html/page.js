"use strict";
(() => {
  const root = document.documentElement;
  const errors = [];
  addEventListener("error", (e) => errors.push(String(e.message)));
  addEventListener("unhandledrejection", (e) => errors.push(String(e.reason)));
  for (const b of document.querySelectorAll(".buttons")) b.hidden = false;
  const dark = () =>
    root.dataset.theme ? root.dataset.theme === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
  document.getElementById("theme").addEventListener("click", () => {
    root.dataset.theme = dark() ? "light" : "dark";
    root.dispatchEvent(new CustomEvent("theme"));
  });
  document.getElementById("print").addEventListener("click", () => print());

  const text = (id) => document.getElementById(id)?.textContent;
  const inflate = async (base64) => {
    const packed = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  };
  globalThis.amcheck = { inflate };
  const host = document.getElementById("viewer");
  const without = (why) => {
    host.hidden = true;
    root.classList.remove("live");
    const note = document.getElementById("viewer-note");
    note.textContent = "The 3-D view is not shown: " + why + ". The pictures show the same.";
    note.hidden = false;
    root.dataset.ready = "fallback";
  };
  const start = async () => {
    if (!text("viewer-part")) {
      root.dataset.ready = "1";
      return;
    }
    if (typeof DecompressionStream === "undefined") return without("this browser is too old for it");
    try {
      const [program, part] = await Promise.all([inflate(text("viewer-program")), inflate(text("viewer-part"))]);
      const address = URL.createObjectURL(new Blob([program], { type: "text/javascript" }));
      const viewer = await import(address);
      URL.revokeObjectURL(address);
      host.hidden = false;
      root.classList.add("live");
      for (const b of document.querySelectorAll(".step")) b.hidden = false;
      const asked = location.hash;
      const view = viewer.start(host, part, JSON.parse(text("report-json")));
      if (asked === "#selftest") {
        const said = Object.assign(document.createElement("pre"), { id: "selftest", hidden: true });
        const result = view.selfTest();
        result.slices = (await amcheck.slices?.()) ?? null;
        said.textContent = JSON.stringify({ ...result, errors });
        document.body.append(said);
      }
      root.dataset.ready = "1";
    } catch (e) {
      without(String(e?.message ?? e));
    }
  };
  start();
})();
