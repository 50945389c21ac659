// Opening and saving, on top of the page.
import { useRef } from "preact/hooks";
import { bring, save } from "../kernel/loader";
import { Icon } from "../parts/icons";

export function FileButtons() {
  const field = useRef<HTMLInputElement>(null);
  return (
    <>
      <input ref={field} type="file" hidden id="open-scene" aria-label="Scene to open" accept=".yaml,.yml,.zip"
        onChange={(event) => {
          const [file] = event.currentTarget.files ?? [];
          event.currentTarget.value = "";
          if (file) void bring(new Map([[file.name, file]]));
        }} />
      <button type="button" class="tool" title="Open a scene" onClick={() => field.current?.click()}><Icon name="folder-open" /></button>
      <button type="button" class="tool" id="save" title="Save the cell: a scene, with the files that it needs" onClick={() => void save()}><Icon name="save" /></button>
    </>
  );
}
