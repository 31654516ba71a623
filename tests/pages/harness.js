"use strict";
// Opens pages one after the other in a frame, lets each test itself, and writes down what was seen.
(async () => {
  const read = (id) => JSON.parse(document.getElementById(id).textContent);
  const { names, axe, modes } = read("asked");
  const seen = {};
  const wait = (ms) => new Promise((done) => setTimeout(done, ms));
  const frame = async (address, sandbox) => {
    const f = document.createElement("iframe");
    f.width = 1320;
    f.height = 1000;
    if (sandbox) f.setAttribute("sandbox", "allow-same-origin");
    const loaded = new Promise((done) => f.addEventListener("load", done));
    f.src = address;
    document.body.append(f);
    await loaded;
    return f;
  };
  const root = (f) => f.contentDocument.documentElement;

  /** The rules of axe over the page as it stands, every fold open. */
  const judge = async (f, theme) => {
    const d = f.contentDocument;
    root(f).dataset.theme = theme;
    d.querySelectorAll("details").forEach((e) => { e.open = true; });
    if (!f.contentWindow.axe) {
      const s = d.createElement("script");
      s.textContent = axe;
      d.head.append(s);
    }
    const r = await f.contentWindow.axe.run(d, { resultTypes: ["violations"] });
    const said = (v) => `${theme}: ${v.id}, ${v.nodes.length} times, first ${v.nodes[0].html.slice(0, 200)}`;
    return { violations: r.violations.map(said), passes: r.passes.length };
  };

  const look = async (name) => {
    const out = {};
    const f = await frame(name + "#selftest");
    for (let i = 0; i < 600 && !root(f).dataset.ready; i++) await wait(50);
    out.ready = root(f).dataset.ready ?? null;
    out.note = f.contentDocument.getElementById("viewer-note")?.textContent ?? "";
    out.itself = JSON.parse(f.contentDocument.getElementById("selftest")?.textContent ?? "null");
    out.fetched = f.contentWindow.performance.getEntriesByType("resource").map((e) => e.name).filter((n) => !/^(file|data|blob):/.test(n));
    const link = f.contentDocument.querySelector("[data-finding]")?.id;
    if (axe) out.axe = [await judge(f, "light"), await judge(f, "dark")];
    f.remove();
    if (modes.includes("link") && link) {
      const g = await frame(name + "#" + link);
      for (let i = 0; i < 600 && !root(g).dataset.ready; i++) await wait(50);
      out.link = [link, g.contentDocument.querySelector(".finding.current")?.id ?? null];
      g.remove();
    }
    if (modes.includes("scriptless")) {
      const g = await frame(name, true);
      const d = g.contentDocument;
      out.scriptless = {
        ready: root(g).dataset.ready ?? null, findings: d.querySelectorAll("li.finding").length, headline: d.querySelector("h1").textContent,
        pictures: [...d.images].filter((i) => i.complete && i.naturalWidth > 0).length, broken: [...d.images].filter((i) => !i.naturalWidth).length,
        shown: [...d.querySelectorAll(".view")].filter((v) => getComputedStyle(v).display !== "none").length, rows: d.querySelectorAll("table.checks tbody tr").length,
      };
      g.remove();
    }
    return out;
  };

  for (const name of names) {
    try { seen[name] = await look(name); } catch (e) { seen[name] = { broken: String(e?.stack ?? e) }; }
  }
  const pre = document.createElement("pre");
  pre.id = "seen";
  pre.textContent = JSON.stringify(seen);
  document.body.append(pre);
})();
