// Everything that can be pressed is large enough, or has room around it
// (WCAG 2.2, target size).

/** Runs on the page: the controls smaller than 24 pixels without room around them. */
function tooSmall() {
  const LEAST = 24;
  const kinds =
    "button, a[href], input, select, summary, textarea, [role=button], [role=tab], [role=slider], [tabindex='0'][data-id]";
  const shown = (node) => node.checkVisibility({ visibilityProperty: true });
  // The size of a node in a drawing depends on the zoom; it can be pressed in a list as well.
  const isDrawn = (node) => node instanceof SVGElement;
  // A label is a part of its checkbox.
  const boxOf = (node) => (node.type === "checkbox" ? (node.closest("label") ?? node) : node).getBoundingClientRect();
  const all = [...document.querySelectorAll(kinds)]
    .filter((node) => shown(node) && !isDrawn(node))
    .map((node) => ({ node, box: boxOf(node) }));
  const here = all.filter(({ box }) => box.width > 0 && box.height > 0);
  const isSmall = ({ box }) => box.width < LEAST - 0.5 || box.height < LEAST - 0.5;
  const middle = ({ left, top, width, height }) => [left + width / 2, top + height / 2];
  const isNear = (one, other) => {
    const [x, y] = middle(one.box);
    const { left, right, top, bottom } = other.box;
    const away = Math.hypot(Math.max(left - x, 0, x - right), Math.max(top - y, 0, y - bottom));
    const [u, v] = middle(other.box);
    return away < LEAST / 2 || (isSmall(other) && Math.hypot(x - u, y - v) < LEAST);
  };
  const crowds = (one) =>
    here.some(
      (other) =>
        other !== one && !other.node.contains(one.node) && !one.node.contains(other.node) && isNear(one, other),
    );
  const name = ({ node, box }) => {
    const text = (node.getAttribute("aria-label") ?? node.innerText ?? "").slice(0, 30).replace(/\s+/g, " ");
    return `${node.tagName.toLowerCase()}.${node.getAttribute("class") ?? ""} "${text}" ${box.width.toFixed(0)} x ${box.height.toFixed(0)}`;
  };
  return here.filter((one) => isSmall(one) && crowds(one)).map(name);
}

/** No target on any tab is too small. */
export async function targets({ page, look, same }) {
  const found = new Set();
  const measure = async () => {
    await page.waitForTimeout(300);
    for (const one of await page.evaluate(`(${tooSmall})()`)) found.add(one);
  };
  const first = await look((r) => r.store.scene.objects[0].name);
  await page.locator(`.tree-row[data-name="${first}"]`).click();
  for (const tab of await page.getByRole("tab").all()) {
    await tab.click();
    await measure();
  }
  await page.keyboard.press("Escape");
  await measure();
  await page.getByRole("button", { name: "More of the recorder" }).click();
  await measure();
  await page.keyboard.press("Escape");
  await page.locator(".scene-open").click();
  await measure();
  await page.keyboard.press("Escape");
  await page.keyboard.press("?");
  await measure();
  await page.keyboard.press("Escape");
  same("targets that are too small", [...found], []);
}
