// What the card of the first minute says of each demo.
import type { Scene } from "../../net/protocol";

export interface Try {
  what: string;
  /** Command line that does it. */
  command: string;
}

export interface Guide {
  title: string;
  /** Description of the demo. */
  see: string;
  tries: Try[];
}

const BY_HAND: Try = {
  what: "Be the task: pause it and click a bin on the belt. Above, Approach and Close are in the panel of the bin; the arrows at the tool lead the arm.",
  command: "robocell task pause",
};

const GUIDES: Record<string, Guide> = {
  "franka-stack": {
    title: "One arm stacks four cubes",
    see: "A Franka grips each cube by friction and puts it on the stack. The task checks the cubes 100 times a second and recovers from your disturbances.",
    tries: [
      {
        what: "Pull the blue cube away: Shift+drag, with Ctrl up and down. The task fetches it again.",
        command: "robocell drag blue_cube --to 0.5 -0.2 0.025",
      },
      {
        what: "Restart the task while a cube is in the hand: the arm holds it, and the task resumes.",
        command: "robocell restart task",
      },
      {
        what: "Be the task: pause it and click a cube. Above, Approach and Close are in its panel; the arrows at the tool lead the arm.",
        command: "robocell task pause",
      },
    ],
  },
  "franka-pyramid": {
    title: "Two arms share one pyramid",
    see: "Two Frankas take a pyramid of six cubes apart and build two stacks of three. Only one arm at a time may enter the centre; the panel Pyramid shows which.",
    tries: [
      {
        what: "Pull a cube away from an arm: Shift+drag, with Ctrl up and down. Its tree recovers.",
        command: "robocell drag cube_1 --to 0.3 0 0.025",
      },
      { what: "Watch both trees while they run.", command: "robocell bt show --live" },
      { what: "Restart one process; both arms hold, and nothing falls.", command: "robocell restart controller" },
    ],
  },
  reach: {
    title: "An arm follows your target",
    see: "The controller leads the tool to the target and keeps the arm within its limits. No task runs that moves anything else.",
    tries: [
      { what: "Drag the arrows at the tool, or send a target.", command: "robocell target 0.4 0.1 0.5" },
      {
        what: "Ask for a target out of reach: the arm stops short of it.",
        command: "robocell target 1.2 0 0.5 --no-wait",
      },
      {
        what: "Bring an arm of your own.",
        command: "robocell run reach --robot my.urdf --xrdf my.xrdf --rmpflow my_rmpflow.yaml",
      },
    ],
  },
  "reach-shelf": {
    title: "An arm plans its way through a shelf",
    see: "The arm moves from one compartment of the shelf to the other, on a planned path around the boards. A post in the way makes it plan again.",
    tries: [
      {
        what: "Pull the post into the way: Shift+drag. The arm plans another path.",
        command: "robocell drag post --to 0.45 0 0.25",
      },
      {
        what: "Restart the controller while the arm is between the boards: the arm holds.",
        command: "robocell restart controller",
      },
      { what: "Pause the task and lead the arm by the arrows at its tool.", command: "robocell task pause" },
    ],
  },
  "ur10-palletize": {
    title: "Bins off a belt, onto a pallet",
    see: "A UR10 takes nine bins off a conveyor with a suction cup. A bin that arrives upside down is turned over on the jig first.",
    tries: [
      { what: "Add another bin.", command: "robocell add-bin" },
      BY_HAND,
      { what: "Watch the state machine and its transitions.", command: "robocell fsm show --live" },
      { what: "Restart the task while a bin hangs at the cup: it resumes.", command: "robocell restart task" },
    ],
  },
  "ur10-fill-bin": {
    title: "A bin filled until the grip breaks",
    see: "A UR10 holds a bin under a dispenser. The parts get too heavy for the suction cup; the bin falls and is picked up again.",
    tries: [
      { what: "Start the task: it waits for its start event.", command: "robocell task start" },
      { what: "Drop parts into the bin and watch the load of the cup.", command: "robocell drop-parts 6" },
      { what: "Watch the matrix of events and states.", command: "robocell fsm show --live" },
    ],
  },
  "ur10-bin-stack": {
    title: "36 bins in nine columns",
    see: "A UR10 stacks bins off a conveyor, all upside down. One that opens upward is turned over in a holder of rails on the way.",
    tries: [
      { what: "Start the task: it waits for its start event.", command: "robocell task start" },
      BY_HAND,
      { what: "Add another bin, upside down.", command: "robocell add-bin --flipped" },
      { what: "Restart the task while it carries a bin: it resumes.", command: "robocell restart task" },
    ],
  },
  cube: {
    title: "One small job, six ways to write it",
    see: "A Franka puts a cube on a mark. The job is written as if/else, state machine, tree in code, tree in a file, table and matrix.",
    tries: [
      { what: "Continue the job with another policy.", command: "robocell restart task --policy tree" },
      {
        what: "Take the cube off its mark: Shift+drag, with Ctrl up and down. The task brings it back.",
        command: "robocell drag cube --to 0.5 -0.2 0.025",
      },
      { what: "Keep the last minute as a file.", command: "robocell record last 60s" },
    ],
  },
};

/** A recording: nothing moves but time. */
export const REPLAY: Guide = {
  title: "A recording",
  see: "What you see was recorded; nothing can be moved. Lanes and marks below say what happened when.",
  tries: [
    { what: "Drag along the timeline. Shift and drag: a range that is looped.", command: "robocell replay FILE" },
    { what: "List the incidents, then show one.", command: "robocell incident" },
  ],
};

/** The guide of a scene; a cell of one's own is described by its file. */
export function guideOf({ demo, description, objects }: Scene): Guide {
  const known = GUIDES[demo];
  if (known !== undefined) return known;
  const [first] = objects;
  const pull: Try =
    first === undefined
      ? { what: "Pause the task and lead the arm by the arrows at its tool.", command: "robocell task pause" }
      : {
          what: "Pull an object: Shift+drag, with Ctrl up and down.",
          command: `robocell drag ${quoted(first.name)} --to 0.5 0 0.1`,
        };
  return {
    title: demo,
    see: description,
    tries: [
      pull,
      { what: "Restart the task: the arm holds, and the task resumes.", command: "robocell restart task" },
      { what: "Keep the last minute as a file.", command: "robocell record last 60s" },
    ],
  };
}

/** `name` as one word for a shell. */
function quoted(name: string): string {
  return /^[\w.-]+$/.test(name) ? name : `'${name.replaceAll("'", "'\\''")}'`;
}
