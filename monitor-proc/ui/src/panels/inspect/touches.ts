// What a body touches, with the force of each contact.
import { nameOf, norm, touchesOf } from "../../net/contacts";
import { type ContactBody, FLAG, OBJECT } from "../../net/snapshot";
import type { PanelContext } from "../context";
import { el, setText, setTitle } from "../dom";
import { list, type Row } from "./rows";

const MOST = 6;

export function touchRows(context: PanelContext, body: ContactBody): Row {
  const none = el("p", { class: "dim" });
  const lines = Array.from({ length: MOST }, () => {
    const name = el("span");
    const force = el("b", { class: "num" });
    return { name, force, node: el("li", { class: "fact wide" }, name, force) };
  });
  const all = el("ul", {}, ...lines.map((line) => line.node));
  const node = el("div", { class: "touches" }, el("h4", {}, "Contacts"), all, none);
  const show = () => {
    const { scene, snapshot } = context.store;
    if (scene === null || snapshot === null) return;
    const touches = touchesOf(snapshot.contacts, body);
    for (const [index, line] of lines.entries()) {
      const touch = touches[index];
      line.node.hidden = touch === undefined;
      if (touch === undefined) continue;
      setText(line.name, nameOf(scene, touch.partner));
      setText(line.force, `${norm(touch.force).toFixed(1)} N`);
      const points = touch.points === 1 ? "1 point" : `${touch.points} points`;
      setTitle(line.node, `force ${list(touch.force, 2)} N (world frame), ${points}`);
    }
    const isPast = context.flag(FLAG.notLive);
    const flags = body.kind === "object" ? (snapshot.objects[body.index]?.flags ?? 0) : 0;
    // Physics computes no contacts of what rests and is not touched.
    const without = (flags & OBJECT.asleep) !== 0 ? "at rest: no contact is computed" : "none";
    const more = touches.length > MOST ? `and ${touches.length - MOST} more` : "";
    setText(none, isPast ? "not recorded" : touches.length === 0 ? without : more);
  };
  return { node, show };
}
