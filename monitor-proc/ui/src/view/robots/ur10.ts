// The UR10: silver tubes, dark joints with blue lids, and its suction tube.
import type { Vec3 } from "../../net/protocol";
import { PAINT } from "../materials";
import { cylinder, taper } from "../shapes";
import { type Dress, type Part, part, QUARTER } from "./part";

const { silver, dark, sky, rubber, steel } = PAINT;
const SIDEWAYS: Vec3 = [QUARTER, 0, 0];
const TUBE_M = 0.155;

function lid(radius: number, at: Vec3, turn: Vec3 = SIDEWAYS): Part {
  return part(cylinder(radius, 0.03, 0.008), sky, at, turn);
}

function base(): Part[] {
  return [
    part(cylinder(0.096, 0.028, 0.008), silver, [0, 0, 0.014]),
    part(cylinder(0.087, 0.05, 0.008), dark, [0, 0, 0.05]),
  ];
}

function shoulder(): Part[] {
  return [
    part(cylinder(0.088, 0.15, 0.02, 0.086), dark, [0, 0, -0.02]),
    part(cylinder(0.084, 0.19, 0.02), dark, [0, 0.02, 0], SIDEWAYS),
    lid(0.078, [0, -0.088, 0]),
  ];
}

function upperArm(): Part[] {
  return [
    part(cylinder(0.084, 0.15, 0.02), silver, [0, -0.03, 0], SIDEWAYS),
    lid(0.078, [0, 0.052, 0]),
    part(taper([0, -0.03, 0.05], [0, -0.03, 0.57], 0.067, 0.058), silver),
    part(cylinder(0.0655, 0.17, 0.02), dark, [0, -0.05, 0.612], SIDEWAYS),
    lid(0.059, [0, 0.04, 0.612]),
  ];
}

function forearm(): Part[] {
  return [
    part(cylinder(0.061, 0.1, 0.015), silver, [0, 0.01, 0], SIDEWAYS),
    lid(0.055, [0, -0.05, 0]),
    part(taper([0, 0.01, 0.04], [0, 0.01, 0.53], 0.05, 0.043), silver),
    part(cylinder(0.05, 0.09, 0.012), silver, [0, 0.01, 0.5723], SIDEWAYS),
  ];
}

function firstWrist(): Part[] {
  return [
    part(cylinder(0.048, 0.13, 0.012), dark, [0, 0.09, 0], SIDEWAYS),
    lid(0.044, [0, 0.022, 0]),
    part(cylinder(0.0465, 0.1, 0.012), dark, [0, 0.1149, 0.01]),
  ];
}

function secondWrist(): Part[] {
  return [
    part(cylinder(0.047, 0.13, 0.012), dark, [0, 0, 0.09]),
    lid(0.043, [0, 0, 0.158], [0, 0, 0]),
    part(cylinder(0.046, 0.09, 0.012), dark, [0, 0.01, 0.1157], SIDEWAYS),
  ];
}

function thirdWrist(): Part[] {
  return [part(cylinder(0.045, 0.04, 0.008), silver, [0, 0.0725, 0], SIDEWAYS)];
}

/** A part of the tool: it sticks out along +x of the flange's frame. */
function tool(from: number, to: number, radius: number, look: Part["look"], tip = radius): Part {
  const middle: Vec3 = [(from + to) / 2, 0, 0];
  return part(cylinder(radius, to - from, 0.003, tip), look, middle, [0, QUARTER, 0]);
}

/** The suction tube: mount, tube, bellows and cup. */
function suction(): Part[] {
  const bellows = [0, 1, 2].map((fold) =>
    tool(TUBE_M - 0.042 + 0.01 * fold, TUBE_M - 0.031 + 0.01 * fold, 0.0165, rubber, 0.0195),
  );
  return [
    tool(0, 0.022, 0.036, dark),
    tool(0.018, TUBE_M - 0.036, 0.0125, steel),
    tool(0.05, 0.062, 0.0165, dark),
    ...bellows,
    tool(TUBE_M - 0.013, TUBE_M, 0.018, rubber, 0.029),
  ];
}

export const ur10Dress: Dress = {
  base_link: base,
  shoulder_link: shoulder,
  upper_arm_link: upperArm,
  forearm_link: forearm,
  wrist_1_link: firstWrist,
  wrist_2_link: secondWrist,
  wrist_3_link: thirdWrist,
  ee_link: suction,
};
