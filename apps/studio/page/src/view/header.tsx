// At the top: what was found, in one sentence, and what can be done with it.

import type { JSX } from "preact";

import { canUndo } from "../state/model";
import { progress } from "../state/progress";
import { canFly, fly } from "../state/server";
import { headline, undo } from "../state/studio";
import { chooseFiles, exportFile, saveModel } from "../state/files";
import type { ExportKind } from "../state/files";
import { flights } from "../state/flights";
import { Menu } from "./menu";
import { canPlan, openPlan } from "./plan_dialog";
import { isNarrow } from "./screen";

const SIGNS = { good: "✓", caution: "!", bad: "✕", none: "" } as const;

export function Header(): JSX.Element {
  return (
    <header class="top">
      <p class="brand"><span class="mark" aria-hidden="true" />Pylon <span class="brand-rest">studio</span></p>
      {isNarrow.value ? null : <Sentence />}
      <div class="acts">
        {isNarrow.value && flights.value.length > 0 ? <button type="button" onClick={chooseFiles}>Open…</button> : null}
        <button type="button" onClick={undo} disabled={!canUndo.value} title="Take the newest revision back">Undo</button>
        <button type="button" onClick={() => void saveModel()} disabled={flights.value.length === 0} title="Save the model file">Save</button>
        <Export />
        {flights.value.length > 0 && !isNarrow.value ? <button type="button" disabled={!canPlan() || progress.value !== null} title="Plan the next flight" onClick={openPlan}>Plan</button> : null}
        {canFly.value ? <button type="button" disabled={progress.value !== null} onClick={() => void fly()}>Fly in QEMU</button> : null}
      </div>
      <Progress />
    </header>
  );
}

export function Sentence(): JSX.Element {
  const { sentence, tone } = headline.value;
  return (
    <h1 class={`sentence ${tone}`} data-tour="sentence" aria-live="polite">
      {tone === "none" ? null : <span class="sign" aria-hidden="true">{SIGNS[tone]}</span>}
      <span>{sentence}</span>
    </h1>
  );
}

function Progress(): JSX.Element | null {
  const now = progress.value;
  if (!now) return null;
  return (
    <div class="progress">
      <span class="progress-bar" style={{ width: now.share === null ? "100%" : `${now.share * 100}%` }} />
      <p class="progress-text" role="status">
        {now.text}…{now.share === null ? "" : ` ${Math.round(now.share * 100)} %`}
        {now.cancel ? <button type="button" class="plain" onClick={now.cancel}>Cancel</button> : null}
      </p>
    </div>
  );
}

const KINDS: ReadonlyArray<{ kind: ExportKind; text: string }> = [
  { kind: "model", text: "Model (TOML)" },
  { kind: "page", text: "This page with its flights (HTML)" },
  { kind: "flight", text: "Flight (CSV)" },
  { kind: "compare", text: "Comparison (JSON)" },
  { kind: "diagnose", text: "Diagnosis (JSON)" },
  { kind: "ladder", text: "Revisions (JSON)" },
];

function Export(): JSX.Element | null {
  if (flights.value.length === 0) return null;
  return (
    <Menu summary={<summary class="button">Export</summary>}>
      {(close) => (
        <>
          {KINDS.map(({ kind, text }) => (
            <button key={kind} type="button" class="plain" onClick={() => { close(); void exportFile(kind); }}>{text}</button>
          ))}
          <button type="button" class="plain" onClick={() => { close(); print(); }}>Print this page</button>
        </>
      )}
    </Menu>
  );
}
