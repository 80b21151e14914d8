// Short names of joints, for where there is little room.

/** Without what all have in front, the robot's name, and without `_joint` behind. */
export function shortNames(names: string[]): string[] {
  const [first = ""] = names;
  const robot = first.slice(0, first.indexOf("_") + 1);
  const shared = names.every((name) => name.startsWith(robot));
  return names.map((name) => name.slice(shared ? robot.length : 0).replace(/_joint$/, ""));
}
