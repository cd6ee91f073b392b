// The page's words for what can be planned.

import type { Offer, PlannedManoeuvre, PlannedSegment } from "../protocol";

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

/** A segment as a pilot reads it. */
export function segmentText({ manoeuvre, airspeed_mps, flight_path_deg, bank_deg, load_factor }: PlannedSegment): string {
  const speed = `${Math.round(airspeed_mps)} m/s`;
  const degrees = (value: number): string => `${Math.abs(Math.round(value * 10) / 10)}°`;
  switch (manoeuvre) {
    case "accelerate": return `Accelerate to ${speed}, level`;
    case "decelerate": return `Slow down to ${speed}, level`;
    case "climb": return `Climb at ${degrees(flight_path_deg ?? 0)}, ${speed}`;
    case "dive": return load_factor === null
      ? `Descend at ${degrees(flight_path_deg ?? 0)}, ${speed}`
      : `Push over to ${degrees(flight_path_deg ?? 0)} down, not below ${load_factor.toFixed(1)} g`;
    case "pull_up": return `Pull up to ${degrees(flight_path_deg ?? 0)}, not above ${(load_factor ?? 1).toFixed(1)} g`;
    case "turn": return `Turn ${(bank_deg ?? 0) > 0 ? "right" : "left"} at ${degrees(bank_deg ?? 0)} of bank, ${speed}`;
    case "level_off": return `Level off, ${speed}`;
    default: return `Straight and level, ${speed}`;
  }
}


/** A range, from its least to its greatest value. */
export function rangeText(range: ReadonlyArray<number>, digits = 0): string {
  return range.map((value) => value.toFixed(digits).replace("-", "−")).join(" to ");
}
