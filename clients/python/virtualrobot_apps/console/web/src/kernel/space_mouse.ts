// A space mouse by WebHID, which browsers of the Chromium family have. Reports are those of 3Dconnexion's devices: 1 has the
// translation, of newer devices the rotation after it, 2 the rotation, 3 the buttons as bits; numbers of 16 bits, to 350.
import type { State } from "./devices";
import { say } from "./messages";

interface Report extends Event {
  reportId: number;
  data: DataView;
}

interface HidDevice extends EventTarget {
  productName: string;
  vendorId: number;
  productId: number;
  collections: readonly { usagePage?: number; usage?: number }[];
  opened: boolean;
  open(): Promise<void>;
}

interface Hid extends EventTarget {
  getDevices(): Promise<HidDevice[]>;
  requestDevice(options: { filters: object[] }): Promise<HidDevice[]>;
}

const AXES = ["x", "y", "z", "rx", "ry", "rz"];
const FULL = 350;
const TRANSLATION = 1, ROTATION = 2, PRESSED = 3;
const MULTI_AXIS = { usagePage: 1, usage: 8 };
const MAKER = 0x256f, OLD_MAKER = 0x046d;
/** Devices that Logitech sold, as the command line knows them. */
const OLD = [0xc603, 0xc605, 0xc606, 0xc621, 0xc623, 0xc625, 0xc626, 0xc627, 0xc628, 0xc629, 0xc62b];
const FILTERS = [{ vendorId: MAKER, ...MULTI_AXIS }, ...OLD.map((productId) => ({ vendorId: OLD_MAKER, productId, ...MULTI_AXIS }))];

const hid = (navigator as { hid?: Hid }).hid;

class SpaceMouse {
  /** How it is; undefined without one. */
  state: State | undefined;
  readonly isPossible = hid !== undefined;
  #device: HidDevice | undefined;
  #counts = AXES.map(() => 0);
  #pressed = 0;

  constructor() {
    if (!hid) return;
    hid.addEventListener("disconnect", (event) => deviceOf(event) === this.#device && this.#drop());
    // Those that a person has chosen before.
    hid.addEventListener("connect", (event) => !this.#device && isSpaceMouse(deviceOf(event)) && void this.#open(deviceOf(event)));
    void hid.getDevices().then((devices) => this.#open(devices.find(isSpaceMouse)), () => {});
    // What it reports meanwhile may be meant for another window, or be lost.
    addEventListener("blur", () => this.#device && (this.#rest(), this.#tell()));
  }

  /** Asks the person for one; the browser shows those that are there. */
  async choose(): Promise<void> {
    await this.#open((await hid?.requestDevice({ filters: FILTERS }))?.[0]);
  }

  async #open(device: HidDevice | undefined): Promise<void> {
    if (!device || device === this.#device) return;
    try {
      if (!device.opened) await device.open();
    } catch (error) {
      return say(`the space mouse ${device.productName} cannot be opened: ${(error as Error).message}`, "error");
    }
    this.#drop();
    this.#device = device;
    device.addEventListener("inputreport", this.#took);
    this.#tell();
  }

  readonly #took = (event: Event) => event.target === this.#device && this.#take(event as Report);

  #drop(): void {
    this.#device = this.state = undefined;
    this.#rest();
  }

  #rest(): void {
    this.#counts.fill(0);
    this.#pressed = 0;
  }

  /** Takes what a report tells; one that is too short, or of another kind, tells nothing. */
  #take({ reportId, data }: Report): void {
    const count = reportId === TRANSLATION && data.byteLength >= 12 ? 6 : 3;
    if ((reportId === TRANSLATION || reportId === ROTATION) && data.byteLength >= 6) {
      const first = reportId === TRANSLATION ? 0 : 3;
      for (let place = 0; place < count; place++) this.#counts[first + place] = data.getInt16(2 * place, true);
    } else if (reportId === PRESSED) {
      this.#pressed = 0;
      for (let place = 0; place < Math.min(4, data.byteLength); place++) this.#pressed |= data.getUint8(place) << (8 * place);
    }
    this.#tell();
  }

  #tell(): void {
    const axes = Object.fromEntries(AXES.map((name, place) => [name, Math.max(-1, Math.min(1, this.#counts[place] / FULL))]));
    const down = Array.from({ length: 32 }, (_, bit) => bit).filter((bit) => (this.#pressed >>> bit) & 1);
    this.state = { name: this.#device?.productName || "space mouse", axes, buttons: new Set(down.map(nameOf)) };
  }
}

function deviceOf(event: Event): HidDevice {
  return (event as Event & { device: HidDevice }).device;
}

function nameOf(bit: number): string {
  return ["left", "right"][bit] ?? `button_${bit + 1}`;
}

function isSpaceMouse({ vendorId, productId, collections }: HidDevice): boolean {
  const fits = collections.some(({ usagePage, usage }) => usagePage === MULTI_AXIS.usagePage && usage === MULTI_AXIS.usage);
  return fits && (vendorId === MAKER || (vendorId === OLD_MAKER && OLD.includes(productId)));
}

export const mouse = new SpaceMouse();
