// Writes a gzip beside each text of the built page: the monitor sends it to browsers that read it.
import { readdirSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { gzipSync } from "node:zlib";

const texts = readdirSync("dist", { recursive: true }).filter((name) => /\.(html|js|css)$/.test(name));
for (const path of texts.map((name) => join("dist", name))) {
  writeFileSync(`${path}.gz`, gzipSync(readFileSync(path), { level: 9 }));
}
