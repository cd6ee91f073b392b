// The keys, in the browser's own dialog.

import type { JSX } from "preact";
import { useRef } from "preact/hooks";

const KEYS: ReadonlyArray<readonly [string, string]> = [
  ["drag", "depends on the switch: brush a stretch, pan, or zoom"],
  ["Shift + drag", "pan"],
  ["wheel, pinch", "zoom about the pointer; sideways or with Shift, pan"],
  ["double-click, 0", "show all of the flight"],
  ["← →", "move the cursor; with Shift, the view"],
  ["+ −", "zoom"],
  ["[ ]", "brush from, and to, the cursor"],
  ["Esc", "end the brush"],
];

export function Help(): JSX.Element {
  const place = useRef<HTMLDialogElement>(null);
  return (
    <>
      <button type="button" class="help-button" aria-label="Mouse and keys" title="Mouse and keys" onClick={() => place.current?.showModal()}>?</button>
      <dialog ref={place} class="help" aria-label="Mouse and keys" onClick={(event) => { if (event.target === place.current) place.current?.close(); }}>
        <form method="dialog">
          <h2>Over the curves</h2>
          <dl>{KEYS.map(([key, text]) => <div key={key}><dt>{key}</dt><dd>{text}</dd></div>)}</dl>
          <p>On the ribbon below, drag the calibration window or its ends, the take-off or the landing, or move them with the arrow keys and Enter. Everything is recomputed.</p>
          <button type="submit" class="main">Close</button>
        </form>
      </dialog>
    </>
  );
}
