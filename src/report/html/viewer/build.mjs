// Rebuilds viewer.min.js.gz, which the crate embeds, and THREE-LICENSE.txt: npm ci && npm run build
import { build } from "esbuild";
import { copyFileSync, writeFileSync } from "node:fs";
import { gzipSync } from "node:zlib";

const result = await build({
  entryPoints: ["viewer.js"],
  bundle: true,
  minify: true,
  treeShaking: true,
  format: "esm",
  target: "es2022",
  legalComments: "inline",
  write: false,
});
const code = result.outputFiles[0].contents;
const packed = gzipSync(code, { level: 9 });
packed[9] = 255; // The header's byte for the system that packed it: unknown, so that every system writes the same.
writeFileSync("viewer.min.js.gz", packed);
copyFileSync("node_modules/three/LICENSE", "THREE-LICENSE.txt");
console.log(`viewer.min.js.gz: ${packed.length} bytes (${code.length} unpacked)`);
