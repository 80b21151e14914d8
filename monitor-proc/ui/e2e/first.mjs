// What a person meets in the first minute: the guide, named views, a sharp picture, reach.

/** The card is there, is closed by a person, stays closed, comes back, and is in no picture. */
export async function guide({ page, look, until, same }) {
  const card = page.locator(".guide-card");
  const opener = page.getByRole("button", { name: "Guide", exact: true });
  const reload = async (hash = "") => {
    await page.evaluate((hash) => history.replaceState(null, "", hash === "" ? location.pathname : hash), hash);
    await page.reload();
    await until("the page shows the cell", (r) => r !== undefined && r.settled());
  };
  await card.waitFor();
  const demo = await look((r) => r.store.scene.demo);
  const commands = await card.locator("code").allInnerTexts();
  same("things to try", commands.length, 3);
  for (const command of commands) if (!command.startsWith("robocell ")) throw new Error(`not a command: ${command}`);
  // A cell of this run has a name of its own where it is not the usual one.
  await page.context().grantPermissions(["clipboard-read", "clipboard-write"]);
  await card.getByRole("button", { name: /^Copy / }).first().click();
  await page.locator(".toast", { hasText: "copied" }).waitFor();
  same("the clipboard", await page.evaluate(() => navigator.clipboard.readText()), commands[0]);
  // What is over the view takes no click meant for it, and the view none meant for the card.
  await look((r) => r.view.select(r.store.scene.arms[0].name));
  await card.locator("h2").click();
  same("the selection", await look((r) => r.view.selection.name), await look((r) => r.store.scene.arms[0].name));
  await page.keyboard.press("Escape");
  await card.waitFor({ state: "hidden" });
  await reload();
  await opener.waitFor();
  same("whether a reload shows what was closed", await card.isVisible(), false);
  await opener.click();
  await card.waitFor();
  await reload();
  await card.waitFor();
  await card.getByRole("button", { name: "Close the guide" }).click();
  await opener.click();
  // One line where there is no room for more.
  await page.setViewportSize({ width: 390, height: 844 });
  await card.waitFor();
  const { height, width } = await card.boundingBox();
  if (height > 40 || width > 390) throw new Error(`the card is ${width} x ${height} px`);
  await page.setViewportSize({ width: 1280, height: 720 });
  for (const hash of ["#shot", "#quality=0"]) {
    await reload(hash);
    same(`cards in a picture of ${demo} at ${hash}`, await page.locator(".guide-card, .guide-opener").count(), 0);
  }
}
