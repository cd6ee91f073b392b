// The page's words for what can be planned.

import type { Offer, PlannedManoeuvre } from "../protocol";

interface Words {
  readonly name: string;
  readonly about: string;
  /** Name of its amount; empty if it has none. */
  readonly amount: string;
}

const WORDS: Readonly<Record<PlannedManoeuvre, Words>> = {
  speed_sweep: { name: "Speed sweep", about: "faster and slower than cruise, level", amount: "±" },
  climbs: { name: "Climbs and descents", about: "level between them", amount: "path" },
  pull_ups: { name: "Pull-ups and push-overs", about: "as much above one g as below", amount: "up to" },
  turns: { name: "Level turns", about: "one to each side", amount: "bank" },
  level: { name: "Straight and level", about: "nothing changes but time", amount: "" },
  long_climb: { name: "Long climb and descent", about: "up, level, and back down", amount: "path" },
  legs: { name: "Straight legs", about: "speeding up and braking, turned by 90°", amount: "±" },
};

export function wordsOf(manoeuvre: PlannedManoeuvre): Words {
  return WORDS[manoeuvre];
}

export function amountUnit(offer: Offer): string {
  return offer.unit === "deg" ? "°" : offer.unit;
}

/** A range, from its least to its greatest value. */
export function rangeText(range: ReadonlyArray<number>, digits = 0): string {
  return range.map((value) => value.toFixed(digits).replace("-", "−")).join(" to ");
}
