// The 3D view without the panels, at /dev/alone.html?demo=...
import { Store } from "../src/net/store";
import { View } from "../src/view/index";
import { startDemo } from "./demo";

const element = document.getElementById("view");
if (element === null) throw new Error("the page has no #view");
const store = new Store();
Object.assign(window, { robocell: { store, view: new View(store, element) } });
startDemo(store);
