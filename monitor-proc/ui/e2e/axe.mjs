// What axe-core finds on the page.
import { readFileSync } from "node:fs";

/** axe-core's own words for what keeps people out. */
const SERIOUS = ["serious", "critical"];

export async function loadAxe(page) {
  await page.evaluate(readFileSync(new URL("../node_modules/axe-core/axe.min.js", import.meta.url), "utf8"));
}

/** Throws where something serious is found. */
export async function accessible(page, where) {
  const found = await page.evaluate("axe.run({ resultTypes: ['violations'] })");
  const serious = found.violations.filter(({ impact }) => SERIOUS.includes(impact));
  const told = serious.map(
    ({ id, nodes }) =>
      `${id}: ${nodes
        .map(({ html }) => html.slice(0, 120))
        .slice(0, 3)
        .join(" | ")}`,
  );
  if (told.length > 0) throw new Error(`${where}: ${told.join("; ")}`);
}
