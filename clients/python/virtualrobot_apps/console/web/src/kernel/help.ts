// What the page's panels are for, and its keys: help where a person is.
import { signal } from "@preact/signals";

export interface About {
  name: string;
  /** What is done there, a sentence each. */
  says: readonly string[];
}

/** Whether help is shown. */
export const helps = signal(false);

export const KEYS: readonly (readonly [keys: string, what: string])[] = [
  ["Space", "STOP, but in fields for words"],
  ["F1", "help for where you are"],
  ["Ctrl-K", "find a command or a node by its words"],
  ["Ctrl-Z, Ctrl-Shift-Z", "undo, redo"],
  ["Q, W, E, M, T, S", "select; drag the tool; turn the tool; move the selected node; turn it; draw its faces out"],
  ["D", "measure"],
  ["N", "names of nodes in the view"],
  ["F, I", "look at what is selected; show it alone"],
  ["1 to 7", "look from the front, back, left, right, top, below, as at first"],
  ["Arrows, + and − in the view", "turn, go nearer and farther; with Shift shift it"],
  ["Arrows, F2, Delete in the tree", "go and open; rename; remove"],
  ["← →, Enter in tabs and choices", "the next one; takes it"],
  ["Shift-F10 in the tree", "the menu of the selected node"],
  ["Enter on a jog's button", "jogs while it is held"],
  ["Enter or Tab, Esc in a number", "takes it; leaves it as it was"],
  ["Esc", "drops the ghost, and what is dragged or placed"],
];

export const ABOUT: Record<string, About> = {
  top: { name: "The bar on top", says: ["Open and save the cell; undo and redo any edit of anybody; hold and step time; slow all robots down.", "STOP lets all robots come to rest on their paths; nobody moves anything until Release is pressed."] },
  view: { name: "The view", says: ["Click selects, with Alt the link of a robot; double click looks at it; the right button opens its menu.", "Drag turns the view, the right button shifts it, the wheel goes nearer.", "Model files that are dropped are loaded where they fall."] },
  scene: { name: "Scene", says: ["All nodes of the cell as they hang on each other. Double click renames, dragging hangs a node elsewhere, the eye hides it.", "Add … makes tables, boxes, cylinders, balls, parts, cameras and range sensors."] },
  library: { name: "Library", says: ["Robots and grippers by name. Choose one, then click where it shall stand, or write the place; a gripper goes to the chosen robot's flange."] },
  pendant: { name: "Pendant", says: ["Hold + or − to jog a joint or the tool; the robot stops when you let go.", "A slider, a number or the dragged tool asks for a ghost: Move to ghost moves the robot there. Of several postures that reach a pose, choose one.", "Teach makes a target where the tool is. Below are the cell's signals, those of the robot first."] },
  parts: { name: "Parts", says: ["The parts that are nearest to the tool, with their distances. Pick takes the chosen one where it is near enough; Place lets it go."] },
  views: { name: "Views", says: ["Look from a side, follow a node, save views in the cell, and look through its cameras.", "A view that is saved while it turns with a node hangs on it.", "With a headset, or a phone that can: stand in the cell, take the tool's ball, and hold to run what was shown."] },
  properties: { name: "Properties", says: ["Name, parent, lock, description, tags, pose, figures and settings of the selected node. Numbers are taken by Enter or Tab."] },
  plot: { name: "Joints over time", says: ["Positions, speeds or torques of the chosen robot's joints, as they go by."] },
  code: { name: "Code", says: ["A program in RAPID or URScript, as its file's ending tells. Faults are told as you write; Run runs it, and a click beside a line's number stops it there, with Shift by a condition.", "Blue is the line that runs, yellow where it stands, green the line whose move the robot makes. What it asks is answered beside the text."] },
  program: { name: "Program", says: ["Steps that are played in order: taught targets, tools, signals, waits, picks and places. Play, single step, and back to before Play.", "Save it as a file that programs and the command line run, too."] },
  curves: { name: "Curves", says: ["Draw any number of any stream over time: /robots/arm/tcp:speed, /sensors/wrist/reading:force/z, or a difference, A - B. A sensor reads while it is drawn."] },
  trajectory: { name: "Trajectory", says: ["Drop a CSV or JSON file of joints at times: it is checked, plotted, shown as a ghost, played, and compared with what was measured."] },
  process: { name: "Process", says: ["A file of a process, such as a weld, as a text. Pick an edge in the view, look where along it the tool gets to (green), something would touch (orange) or it is out of reach (red), then plan and run it."] },
  signals: { name: "Signals", says: ["Values of inputs and outputs, what connects them with machines outside, and their timing."] },
  collisions: { name: "Collisions", says: ["What touches now, what began and ended to touch, how far things are apart, which pairs may touch, and what is done about the rest."] },
  traces: { name: "Traces", says: ["The way of a tool or any node, drawn in the view and kept as a table."] },
  modeller: { name: "Modeller", says: ["The text that the selected body is made by, lengths in meters; buttons put words in, around what is selected."] },
  history: { name: "History", says: ["All edits of anybody, the newest first. Undo takes the newest back that stands."] },
  messages: { name: "Messages", says: ["What was refused and why, what has begun and ended."] },
  speeds: { name: "Speed and time", says: ["How fast all robots and each of them go, the greatest speed of their tools, and how simulation time goes by."] },
  films: { name: "Films", says: ["Films of the view or of a camera, as mp4."] },
  devices: { name: "Devices", says: ["Gamepads, space mice and keys, and what they move: jog, drive, view."] },
  measuring: { name: "Measure", says: ["Click two corners, edges, holes or faces, or name nodes for their origins: distance, what lies squarely between, angle."] },
};
