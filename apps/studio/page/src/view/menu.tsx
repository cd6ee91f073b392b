// A menu that opens below its button. It closes on Escape, on a click elsewhere, and on a choice.

import type { ComponentChildren, JSX } from "preact";
import { useEffect, useRef } from "preact/hooks";

interface MenuProps {
  /** Content of the button. */
  summary: JSX.Element;
  /** Classes in addition to `menu`. */
  class?: string;
  /** Content of the menu; `close` closes it and returns the focus to the button. */
  children: (close: () => void) => ComponentChildren;
}

export function Menu({ summary, class: further, children }: MenuProps): JSX.Element {
  const place = useRef<HTMLDetailsElement>(null);
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
  return (
    <details class={further ? `menu ${further}` : "menu"} ref={place} onKeyDown={(event) => { if (event.key === "Escape") close(); }}>
      {summary}
      <div class="menu-list">{children(close)}</div>
    </details>
  );
}
