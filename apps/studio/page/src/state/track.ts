// Where the flight went, in metres from where its record begins.

import { computed } from "@preact/signals";

import type { TrackPoints } from "../charts/track";
import { shown } from "./flights";
import { points } from "./pictures";

const METRES_A_DEGREE = 111_195;

function has(column: string): boolean {
  return shown.value?.opened.columns.some(({ name, values }) => name === column && values > 0) === true;
}

const positions = points(() => (has("longitude_deg") && has("latitude_deg") ? "longitude_deg" : ""), () => "latitude_deg", true);
const velocities = points(() => (!has("longitude_deg") && has("gps_ve_mps") && has("gps_vn_mps") ? "gps_ve_mps" : ""), () => "gps_vn_mps", true);

export interface FoundTrack extends TrackPoints {
  readonly how: "position" | "velocity";
}

export const trackPoints = computed<FoundTrack | null>(() => {
  const [fixes, moves] = [positions.answer.value, velocities.answer.value];
  if (fixes && fixes.reply.of > 1) {
    const { reply } = fixes;
    const [time, longitude, latitude] = [reply.time_s, reply.x, reply.y];
    const [east, north] = [longitude[0] ?? 0, latitude[0] ?? 0];
    const shrink = Math.cos((north * Math.PI) / 180);
    return {
      how: "position",
      time: Array.from(time),
      east: Array.from(longitude, (value) => (value - east) * METRES_A_DEGREE * shrink),
      north: Array.from(latitude, (value) => (value - north) * METRES_A_DEGREE),
    };
  }
  if (moves && moves.reply.of > 1) {
    const { reply } = moves;
    const [time, ve, vn] = [reply.time_s, reply.x, reply.y];
    return { how: "velocity", time: Array.from(time), east: integral(time, ve), north: integral(time, vn) };
  }
  return null;
});

// By the trapezoidal rule.
function integral(time: Float64Array, rate: Float64Array): number[] {
  let sum = 0;
  return Array.from(time, (at, i) => {
    if (i > 0) sum += 0.5 * ((rate[i] ?? 0) + (rate[i - 1] ?? 0)) * (at - (time[i - 1] ?? at));
    return sum;
  });
}
