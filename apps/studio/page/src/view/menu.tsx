// A menu that unfolds below its button, and folds on Escape, on a click elsewhere, and when something is chosen.

import type { ComponentChildren, JSX } from "preact";
import { useEffect, useRef } from "preact/hooks";

interface MenuProps {
  /** What is on the button. */
  summary: JSX.Element;
  /** Classes beside `menu`. */
  class?: string;
  /** What is in it; `close` folds it and gives the focus back to the button. */
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
