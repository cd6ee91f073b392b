// Starts the page: the screen first, then the engine and what was open before.

import { render } from "preact";

import "./looks/tokens.css";
import "uplot/dist/uPlot.min.css";
import "./looks/layout.css";
import "./looks/curves.css";
import "./looks/panels.css";
import "./looks/plan.css";
import "./looks/print.css";
import { notice } from "./state/flights";
import { messageOf } from "./state/resource";
import { inside } from "./state/inside";
import { keepOnChange, openInside, restore } from "./state/session";
import { loadGuides, saidBefore } from "./state/studio";
import { openServed } from "./state/server";
import { App } from "./view/app";

const place = document.getElementById("studio");
if (place) render(<App />, place);

async function begin(): Promise<void> {
  const found = inside();
  if (found) saidBefore.value = found.said;
  try {
    await loadGuides();
    if (found) {
      await openInside(found);
      return;
    }
    await restore();
    await openServed();
  } catch (error) {
    notice.value = messageOf(error);
  }
  keepOnChange();
}

void begin();
