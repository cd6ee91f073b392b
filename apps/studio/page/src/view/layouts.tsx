// What is where, kept under names.

import { useSignal } from "@preact/signals";
import type { JSX } from "preact";
import { useEffect, useRef } from "preact/hooks";

import { dropLayout, keepLayout, layouts, layOut } from "../state/layout";

export function Layouts(): JSX.Element {
  const place = useRef<HTMLDetailsElement>(null);
  const name = useSignal("");
  useEffect(() => {
    const away = (event: Event): void => {
      const menu = place.current;
      if (menu?.open && event.target instanceof Node && !menu.contains(event.target)) menu.open = false;
    };
    document.addEventListener("pointerdown", away);
    return () => document.removeEventListener("pointerdown", away);
  }, []);
  const close = (): void => {
    const menu = place.current;
    if (!menu) return;
    menu.open = false;
    menu.querySelector("summary")?.focus();
  };
  const keep = (event: Event): void => {
    event.preventDefault();
    const wanted = name.value.trim();
    if (wanted === "") return;
    keepLayout(wanted);
    name.value = "";
    close();
  };
  return (
    <details class="menu layouts" ref={place} onKeyDown={(event) => { if (event.key === "Escape") close(); }}>
      <summary class="button" aria-label="Layouts" title="Layouts: what is where, kept under names"><span aria-hidden="true">▤</span></summary>
      <div class="menu-list">
        {layouts.value.map((one) => (
          <span key={one.name} class="layout">
            <button type="button" class="plain" onClick={() => { layOut(one.layout); close(); }}>{one.name}</button>
            <button type="button" class="plain close" aria-label={`Forget the layout ${one.name}`} onClick={() => dropLayout(one.name)}>×</button>
          </span>
        ))}
        <form onSubmit={keep}>
          <input type="text" aria-label="Name of this layout" placeholder="Name of this layout" maxLength={40} value={name.value} onInput={(event) => { name.value = event.currentTarget.value; }} />
          <button type="submit" disabled={name.value.trim() === ""}>Keep</button>
        </form>
      </div>
    </details>
  );
}
