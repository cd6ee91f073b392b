// The screen.

import { useSignal } from "@preact/signals";
import type { JSX } from "preact";
import { useEffect } from "preact/hooks";

import { openFiles } from "../state/files";
import { flights, notice } from "../state/flights";
import { Effects } from "./effects";
import { FirstScreen } from "./first_screen";
import { FlightsPanel } from "./flights_panel";
import { Header, Sentence } from "./header";
import { LadderPanel } from "./ladder_panel";
import { Middle } from "./middle";
import { FlightCard } from "./flight_card";
import { Panels } from "./panels";
import { PlanDialog } from "./plan_dialog";
import { isNarrow } from "./screen";
import { Tour } from "./tour";

export function App(): JSX.Element {
  const isDropping = useSignal(false);
  useEffect(() => {
    let depth = 0;
    const enter = (event: DragEvent): void => {
      if (!event.dataTransfer?.types.includes("Files")) return;
      depth += 1;
      isDropping.value = true;
    };
    const leave = (): void => {
      depth = Math.max(depth - 1, 0);
      if (depth === 0) isDropping.value = false;
    };
    const over = (event: DragEvent): void => event.preventDefault();
    const drop = (event: DragEvent): void => {
      event.preventDefault();
      depth = 0;
      isDropping.value = false;
      if (event.dataTransfer) void openFiles(event.dataTransfer.files);
    };
    addEventListener("dragenter", enter);
    addEventListener("dragleave", leave);
    addEventListener("dragover", over);
    addEventListener("drop", drop);
    return () => {
      removeEventListener("dragenter", enter);
      removeEventListener("dragleave", leave);
      removeEventListener("dragover", over);
      removeEventListener("drop", drop);
    };
  }, []);

  const isEmpty = flights.value.length === 0;
  return (
    <div class={`studio ${isEmpty ? "is-first" : ""}`}>
      <Header />
      {isNarrow.value ? <div class="sentence-row"><Sentence /></div> : null}
      {isEmpty ? <FirstScreen /> : (
        <>
          {isNarrow.value ? null : <FlightsPanel />}
          <Middle />
          <Effects />
          {isNarrow.value ? <Panels /> : null}
          <LadderPanel />
          {isNarrow.value ? <FlightsPanel /> : null}
        </>
      )}
      <Notice />
      <PlanDialog />
      <FlightCard />
      <Tour />
      {isDropping.value ? <div class="dropping" aria-hidden="true"><p>Drop to open</p></div> : null}
    </div>
  );
}

function Notice(): JSX.Element | null {
  if (notice.value === null) return null;
  return (
    <div class="notice" role="alert">
      <p>{notice.value}</p>
      <button type="button" class="plain" aria-label="Dismiss" onClick={() => { notice.value = null; }}>×</button>
    </div>
  );
}
