// The findings as the page lists them, with their numbers from the report.
import { Vector3 } from "three";

/** Findings in the order of the page's list, each with its check and anchor. */
export function collect(report) {
  const rest = {};
  for (const check of report.checks) rest[check.name] = check.findings.map((f) => ({ ...f, check: check.name }));
  const found = [];
  for (const li of document.querySelectorAll("[data-finding]")) {
    const anchor = li.id, own = rest[anchor.slice(0, anchor.lastIndexOf("-"))] ?? [];
    const at = JSON.parse(li.dataset.at);
    const k = own.findIndex((f) => f.at_mm.every((x, a) => Math.abs(x - at[a]) < 2e-6));
    if (k >= 0) found.push({ ...own.splice(k, 1)[0], anchor });
  }
  return found;
}

/** The direction towards an eye at an azimuth and elevation in degrees. */
export function direction(azimuth, elevation) {
  const a = (azimuth * Math.PI) / 180, e = (elevation * Math.PI) / 180;
  return new Vector3(Math.cos(e) * Math.cos(a), Math.cos(e) * Math.sin(a), Math.sin(e));
}
