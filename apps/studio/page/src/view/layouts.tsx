// Layouts that are kept under names.

import { useSignal } from "@preact/signals";
import type { JSX } from "preact";

import { dropLayout, keepLayout, layouts, layOut } from "../state/layout";
import { Menu } from "./menu";

const BUTTON = (
  <summary class="button" aria-label="Layouts" title="Layouts: what is where, kept under names"><span aria-hidden="true">▤</span></summary>
);

export function Layouts(): JSX.Element {
  const name = useSignal("");
  const keep = (event: Event, close: () => void): void => {
    event.preventDefault();
    const wanted = name.value.trim();
    if (wanted === "") return;
    keepLayout(wanted);
    name.value = "";
    close();
  };
  return (
    <Menu class="layouts" summary={BUTTON}>
      {(close) => (
        <>
          {layouts.value.map((one) => (
            <span key={one.name} class="layout">
              <button type="button" class="plain" onClick={() => { layOut(one.layout); close(); }}>{one.name}</button>
              <button type="button" class="plain close" aria-label={`Forget the layout ${one.name}`} onClick={() => dropLayout(one.name)}>×</button>
            </span>
          ))}
          <form onSubmit={(event) => keep(event, close)}>
            <input type="text" aria-label="Name of this layout" placeholder="Name of this layout" maxLength={40} value={name.value} onInput={(event) => { name.value = event.currentTarget.value; }} />
            <button type="submit" disabled={name.value.trim() === ""}>Keep</button>
          </form>
        </>
      )}
    </Menu>
  );
}
