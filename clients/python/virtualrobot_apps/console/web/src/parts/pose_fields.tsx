// A pose in numbers: millimeters, and the rotation as people like it.
import { signal } from "@preact/signals";
import { Choice } from "./choice";
import { NumberField } from "./number_field";
import { DEGREES, type AnyPose, ofRollPitchYaw, orientationOf, positionOf, rollPitchYaw, rotationVector } from "./numbers";

type Notation = "rpy" | "vector" | "quaternion";

const notation = signal<Notation>("rpy");
const COLORS = ["var(--x)", "var(--y)", "var(--z)"];
const AXES = ["x", "y", "z"] as const;

export function NotationChoice() {
  const options = [
    ["rpy", "RPY", "Roll, pitch, yaw about the fixed axes x, y, z, in this order, °"], ["vector", "Vector", "Rotation vector: axis times angle, rad"],
    ["quaternion", "Quat", "Unit quaternion x, y, z, w"],
  ] as const;
  return <Choice label="Notation of rotations" options={options} chosen={notation.value} choose={(one) => (notation.value = one)} />;
}

interface Props {
  pose?: AnyPose;
  /** Takes what a field makes of a pose when it is written; without it numbers are only shown. */
  write?: (edit: (pose?: AnyPose) => AnyPose) => void;
}

export function PoseFields({ pose, write }: Props) {
  const position = positionOf(pose), orientation = orientationOf(pose);
  const angles = rollPitchYaw(orientation);
  return (
    <div class="pose">
      {AXES.map((axis, place) => (
        <NumberField key={axis} label={axis.toUpperCase()} name={axis.toUpperCase()} color={COLORS[place]} unit="mm" decimals={2}
          value={1000 * position[place]} write={write && ((value) => write((one) => moved(one, place, value / 1000)))} />
      ))}
      {notation.value === "rpy" && ["Roll", "Pitch", "Yaw"].map((about, place) => (
        <NumberField key={about} label={`R${AXES[place]}`} about={`${about}: about the fixed ${AXES[place]}`} name={`R${AXES[place]}`} color={COLORS[place]} unit="°" decimals={2}
          value={DEGREES * angles[place]} write={write && ((value) => write((one) => turned(one, place, value / DEGREES)))} />
      ))}
      {notation.value === "vector" && rotationVector(orientation).map((value, place) => (
        <NumberField key={place} label={`Rotation vector ${AXES[place]}`} name={`r${AXES[place]}`} unit="rad" decimals={4} value={value} />
      ))}
      {notation.value === "quaternion" && ([...AXES, "w"] as const).map((axis) => (
        <NumberField key={axis} label={`Quaternion ${axis}`} name={`q${axis}`} unit="" decimals={4} value={orientation[axis]} />
      ))}
    </div>
  );
}

function moved(pose: AnyPose | undefined, place: number, value: number): AnyPose {
  const [x, y, z] = positionOf(pose).with(place, value);
  return { position: { x, y, z }, orientation: orientationOf(pose) };
}

function turned(pose: AnyPose | undefined, place: number, value: number): AnyPose {
  const [x, y, z] = positionOf(pose), [roll, pitch, yaw] = rollPitchYaw(orientationOf(pose)).with(place, value);
  return { position: { x, y, z }, orientation: ofRollPitchYaw(roll, pitch, yaw) };
}
