// Icons: Lucide's, and some of our own in its style, for what it doesn't have.
const files = import.meta.glob<string>(
  "../../node_modules/lucide-static/icons/{activity,arrow-down,arrow-up,axis-3d,bookmark,box,cable,camera,chart-line,chevron-down,chevron-left,chevron-right,circle-help,code,copy,crosshair,download,eraser,eye,eye-off,file-up,folder-open,footprints,gamepad-2,gauge,globe,grid-3x3,hand,hand-grab,hand-helping,history,hourglass,library,lightbulb,list-ordered,list-video,lock,magnet,map-pin,maximize,message-square,minus,moon,mouse-pointer-2,move,move-3d,move-horizontal,package,pause,pencil,play,plug,plus,radar,rectangle-goggles,redo-2,rotate-3d,rotate-ccw,rotate-cw,route,ruler,save,scaling,scan-eye,search,shapes,shield,square,step-back,step-forward,spline,sun,tag,toggle-left,trash-2,triangle-alert,truck,undo-2,upload,users,video,waypoints,x,zap}.svg",
  { query: "?raw", import: "default", eager: true },
);

const LUCIDE = new Map(
  Object.entries(files).map(([path, text]) => [
    path.split("/").at(-1)!.replace(".svg", ""),
    text.replace(/<!--[\s\S]*?-->/g, "").replace(/^[\s\S]*?<svg[^>]*>/, "").replace("</svg>", ""),
  ]),
);

const OWN = new Map([
  [
    "robot",
    '<path d="M3.5 21h9"/><path d="M8 21v-3"/><circle cx="8" cy="16.2" r="1.8"/><path d="M7.3 14.5 5.6 9.6"/>' +
      '<circle cx="5.2" cy="8" r="1.7"/><path d="m6.6 7 5-3.2"/><circle cx="13.2" cy="3.6" r="1.6"/><path d="m14.4 4.7 3.3 3.6"/>' +
      '<path d="M16 10.4c-.3-1.7 1.4-3.3 3.2-2.9"/><path d="m16 10.4.9 1.9M19.2 7.5l2 .7"/>',
  ],
  ["link", '<path d="M9 15 15 9"/><circle cx="6.7" cy="17.3" r="3.2"/><circle cx="17.3" cy="6.7" r="3.2"/>'],
  ["tool", '<path d="M12 3v5"/><path d="M7 8h10v4H7z"/><path d="M8 12v5l2.5 3M16 12v5l-2.5 3"/>'],
  ["stop", '<path d="M8 2.5h8L21.5 8v8L16 21.5H8L2.5 16V8z"/>'],
]);

const OF_KIND: Record<string, string> = {
  world: "globe", object: "box", part: "package", robot: "robot", gripper: "hand-grab", link: "link", adapter: "plug", tool: "tool",
  annotation: "tag", rangeSensor: "radar", cameraSensor: "camera", contactSensor: "hand", motionSensor: "activity",
  light: "lightbulb", target: "map-pin", viewpoint: "bookmark",
};

const COLOR_OF_KIND: Record<string, string> = {
  robot: "var(--robot)", gripper: "var(--robot)", tool: "var(--tool)", part: "var(--part)", light: "var(--light)", target: "var(--accent)",
  rangeSensor: "var(--sensor)", cameraSensor: "var(--sensor)", contactSensor: "var(--sensor)", motionSensor: "var(--sensor)",
};

interface Look {
  size?: number;
  color?: string;
  width?: number;
}

export function Icon({ name, size = 16, color = "currentColor", width = 1.75 }: Look & { name: string }) {
  const drawn = { __html: OWN.get(name) ?? LUCIDE.get(name) ?? "" };
  return (
    <svg class="icon" width={size} height={size} viewBox="0 0 24 24" fill="none" stroke={color} stroke-width={width}
      stroke-linecap="round" stroke-linejoin="round" aria-hidden="true" dangerouslySetInnerHTML={drawn} />
  );
}

/** The names of the icons that a node may have. */
export const ICONS: readonly string[] = [...LUCIDE.keys(), ...OWN.keys()].sort();

/** The icon of a kind of node, or the node's own (`icon`) where it has one that is here. */
export function KindIcon({ kind, icon = "", size = 15 }: { kind: string; icon?: string; size?: number }) {
  return <Icon name={ICONS.includes(icon) ? icon : OF_KIND[kind] ?? "box"} size={size} color={COLOR_OF_KIND[kind] ?? "var(--muted)"} />;
}
