// What a person in the room has at hand: controllers, hands, and fingers on a screen, read once a frame.
import { Matrix4, Vector3 } from "three";

export interface Hand {
  source: XRInputSource;
  /** Where it takes hold, in the room; undefined for what only points, and while nobody knows where it is. */
  grip?: Matrix4;
  /** Where it points from, along its -z, in the room. */
  ray?: Matrix4;
  /** What touches things, in the room: the tip of a controller's ray, or of the index finger. */
  tip?: Vector3;
  /** Trigger, pinch or touch; and the button under the other fingers. */
  trigger: boolean;
  squeeze: boolean;
  /** B or Y. */
  back: boolean;
  /** Thumbstick to the right and ahead, from -1 to 1. */
  stick: readonly [right: number, ahead: number];
}

/** Places of a gamepad of the mapping `xr-standard`. */
const TRIGGER = 0, SQUEEZE = 1, BACK = 5, STICK_RIGHT = 2, STICK_BACK = 3;
/** Distance (m) of thumb and index finger that is a pinch, where the browser tells none. */
const PINCH_METERS = 0.02;
/** Sources that are there only while they are pressed. */
const MOMENTARY = new Set<string>(["screen", "transient-pointer"]);

interface Tips {
  grip: Matrix4;
  /** That of the index finger, and how far (m) it is from that of the thumb. */
  tip: Vector3;
  apart: number;
}

/** Returns whether a source comes by being pressed, so that its coming is the press. */
export function isMomentary({ targetRayMode }: XRInputSource): boolean {
  return MOMENTARY.has(targetRayMode);
}

export function readHands(frame: XRFrame, room: XRReferenceSpace): Hand[] {
  return [...frame.session.inputSources].map((source) => {
    const tips = source.hand && tipsOf(frame, source.hand, room);
    const pad = source.gamepad, standard = pad?.mapping === "xr-standard";
    const leaned = (axis: number) => (standard ? (pad?.axes[axis] ?? 0) : 0);
    const ray = matrixOf(frame.getPose(source.targetRaySpace, room));
    const pinched = tips !== undefined && tips.apart < PINCH_METERS;
    return {
      source,
      grip: source.hand ? tips?.grip : matrixOf(source.gripSpace && frame.getPose(source.gripSpace, room)),
      ray,
      tip: source.hand ? tips?.tip : ray && new Vector3().setFromMatrixPosition(ray),
      trigger: pad?.buttons[TRIGGER]?.pressed ?? (isMomentary(source) || pinched),
      squeeze: standard && (pad?.buttons[SQUEEZE]?.pressed ?? false),
      back: standard && (pad?.buttons[BACK]?.pressed ?? false),
      stick: [leaned(STICK_RIGHT), -leaned(STICK_BACK)],
    };
  });
}

/** Returns the tips of a hand; its grip is between them and turned as its wrist, which a pinch leaves alone. */
function tipsOf(frame: XRFrame, hand: XRHand, room: XRReferenceSpace): Tips | undefined {
  const [thumb, index, wrist] = (["thumb-tip", "index-finger-tip", "wrist"] as const).map((name) => {
    const joint = hand.get(name);
    return matrixOf(joint && frame.getJointPose?.(joint, room));
  });
  if (!thumb || !index || !wrist) return undefined;
  const one = new Vector3().setFromMatrixPosition(thumb), other = new Vector3().setFromMatrixPosition(index);
  return { grip: wrist.setPosition(one.clone().lerp(other, 0.5)), tip: other, apart: one.distanceTo(other) };
}

function matrixOf(pose: XRPose | null | undefined): Matrix4 | undefined {
  return pose ? new Matrix4().fromArray(pose.transform.matrix) : undefined;
}
