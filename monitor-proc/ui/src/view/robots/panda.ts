// The Panda: white shells, dark joint discs, a ring of light at the foot.
import type { Vec3 } from "../../net/protocol";
import { PAINT } from "../materials";
import { box, cylinder, ring, taper } from "../shapes";
import { type Dress, type Part, part, QUARTER } from "./part";

const { white, dark, steel, rubber, led } = PAINT;
/** Lays a turned part along y. */
const SIDEWAYS: Vec3 = [QUARTER, 0, 0];

/** A joint whose axis is along y: a drum with a dark disc on either side. */
function drum(at: Vec3, radius: number, width: number, disc: number): Part[] {
  return [
    part(cylinder(radius, width, 0.018), white, at, SIDEWAYS),
    part(cylinder(disc, width + 0.012, 0.006), dark, at, SIDEWAYS),
    part(cylinder(disc * 0.62, width + 0.0145, 0.002), rubber, at, SIDEWAYS),
  ];
}

function foot(): Part[] {
  return [
    part(box(0.21, 0.19, 0.045, 0.018), white, [-0.038, 0, 0.0225]),
    part(cylinder(0.08, 0.11, 0.026, 0.066), white, [0, 0, 0.083]),
    part(taper([-0.085, 0, 0.045], [0, 0, 0.075], 0.046, 0.06), white),
    part(box(0.026, 0.09, 0.034, 0.006), dark, [-0.14, 0, 0.034]),
    part(cylinder(0.0665, 0.012, 0.004), dark, [0, 0, 0.144]),
    part(ring(0.0672, 0.0026), led, [0, 0, 0.134]),
  ];
}

function shoulder(): Part[] {
  return [
    part(cylinder(0.0635, 0.125, 0.012, 0.0595), white, [0, 0, -0.118]),
    part(taper([0, 0, -0.075], [0, 0, -0.01], 0.0595, 0.06), white),
    ...drum([0, 0, 0], 0.0615, 0.135, 0.052),
  ];
}

function upperArm(): Part[] {
  return [
    part(taper([0, -0.05, 0], [0, -0.17, 0], 0.0585, 0.0545), white),
    part(cylinder(0.0575, 0.1, 0.014, 0.061), white, [0, -0.185, 0], SIDEWAYS),
    part(cylinder(0.0615, 0.01, 0.003), dark, [0, -0.238, 0], SIDEWAYS),
  ];
}

function elbow(): Part[] {
  return [
    part(cylinder(0.061, 0.06, 0.014), white, [0, 0, -0.047]),
    part(taper([0, 0, -0.045], [0.0825, 0, 0], 0.056, 0.05), white),
    ...drum([0.0825, 0, 0], 0.0545, 0.125, 0.046),
  ];
}

function forearm(): Part[] {
  return [
    part(taper([0, 0, 0], [-0.0825, 0.08, 0], 0.05, 0.054), white),
    part(cylinder(0.0575, 0.056, 0.014, 0.0595), white, [-0.0825, 0.1, 0], [-QUARTER, 0, 0]),
    part(cylinder(0.061, 0.01, 0.003), dark, [-0.0825, 0.131, 0], SIDEWAYS),
  ];
}

function lowerForearm(): Part[] {
  return [
    part(cylinder(0.057, 0.066, 0.016, 0.0605), white, [0, 0, -0.213], [Math.PI, 0, 0]),
    part(taper([0, 0.015, -0.2], [0, 0.066, -0.06], 0.051, 0.041), white),
    part(taper([0, 0, -0.2], [0, 0, -0.02], 0.05, 0.05), white),
    ...drum([0, 0, 0], 0.052, 0.12, 0.043),
  ];
}

function wrist(): Part[] {
  return [
    part(taper([0, 0, 0], [0.088, 0, 0], 0.048, 0.046), white),
    part(cylinder(0.05, 0.1, 0.018), white, [0.088, 0, 0], SIDEWAYS),
    part(cylinder(0.0445, 0.012, 0.004), dark, [0.088, -0.052, 0], SIDEWAYS),
    part(cylinder(0.046, 0.009, 0.003), dark, [0.088, 0.053, 0], SIDEWAYS),
  ];
}

function flange(): Part[] {
  return [
    part(cylinder(0.0455, 0.046, 0.012), white, [0, 0, 0.077]),
    part(cylinder(0.0325, 0.012, 0.003), steel, [0, 0, 0.102]),
    part(box(0.05, 0.036, 0.03, 0.009), dark, [0.043, 0, 0.077]),
    part(cylinder(0.006, 0.034, 0.002), steel, [0.058, 0, 0.077]),
  ];
}

function hand(): Part[] {
  return [
    part(cylinder(0.0345, 0.014, 0.003), dark, [0, 0, 0.006]),
    part(box(0.063, 0.206, 0.05, 0.02), white, [0, 0, 0.033]),
    part(box(0.05, 0.198, 0.013, 0.005), dark, [0, 0, 0.0595]),
  ];
}

/** `side`: 1 for the left finger, -1 for the right. */
function finger(side: number): Part[] {
  return [
    part(box(0.021, 0.02, 0.022, 0.003), steel, [0, 0.0125 * side, 0.012]),
    part(box(0.019, 0.011, 0.038, 0.003), steel, [0, 0.0082 * side, 0.0345]),
    part(box(0.0175, 0.0028, 0.0185, 0.0008), rubber, [0, 0.0014 * side, 0.0452]),
  ];
}

export const pandaDress: Dress = {
  panda_link0: foot,
  panda_link1: shoulder,
  panda_link2: upperArm,
  panda_link3: elbow,
  panda_link4: forearm,
  panda_link5: lowerForearm,
  panda_link6: wrist,
  panda_link7: flange,
  panda_hand: hand,
  panda_leftfinger: () => finger(1),
  panda_rightfinger: () => finger(-1),
};
