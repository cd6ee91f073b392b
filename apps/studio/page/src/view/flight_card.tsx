// The plan as a card to print; it is not shown on the screen.

import type { JSX } from "preact";

import { clock, moment } from "../charts/number";
import { shown } from "../state/flights";
import { planned } from "../state/plan";
import { rangeText, wordsOf } from "./plan_words";

export function FlightCard(): JSX.Element | null {
  const found = planned.value;
  if (!found) return null;
  const { plan, segments, reached, remarks } = found;
  return (
    <section class="flight-card" aria-hidden="true">
      <h1>Flight card</h1>
      <p>{shown.value?.opened.vehicle ?? ""}</p>
      <p>
        {plan.legs.map(({ manoeuvre, times }) => `${times > 1 ? `${times} × ` : ""}${wordsOf(manoeuvre).name.toLowerCase()}`).join(", ")}.
        {" "}{clock(found.duration_s)} in all.
      </p>
      <table>
        <thead><tr><th>#</th><th>At</th><th>Fly</th><th>For</th><th>Altitude then</th><th>Done</th></tr></thead>
        <tbody>
          <tr><td>0</td><td>−{moment(plan.calibration_s)}</td><td>Straight and level, {Math.round(plan.speed_mps)} m/s, {Math.round(plan.altitude_m)} m: calibration, then zero the clock</td><td>{Math.round(plan.calibration_s)} s</td><td>{Math.round(plan.altitude_m)} m</td><td>☐</td></tr>
          {segments.map((segment, at) => (
            <tr key={at}>
              <td>{at + 1}</td><td>{moment(segment.from_s)}</td><td>{segment.words}</td><td>{Math.round(segment.duration_s)} s</td><td>{Math.round(segment.altitude_then_m)} m</td><td>☐</td>
            </tr>
          ))}
        </tbody>
      </table>
      <p>
        As simulated it reaches {rangeText(reached.airspeed_mps)} m/s, {rangeText(reached.altitude_m)} m
        above mean sea level, {rangeText(reached.load_factor, 1)} g, and {(reached.distance_m / 1000).toFixed(1)} km from where it begins.
      </p>
      {remarks.map((remark) => <p key={remark}>{remark}</p>)}
      <p>Pilot ______________________ Date ______________ Wind ______________ QNH ______________</p>
    </section>
  );
}
