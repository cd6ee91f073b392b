//! Planning the next flight ([`planning`]), from the flights that are open.

use std::rc::Rc;

use analysis::diagnose::{Further, diagnose_further};
use flight_data::Flight;
use planning::Planning;
use planning::shortest::shortest;

use crate::engine::{Engine, Progress, Refused, counting, parsed, refused};
use crate::protocol::{DiagnoseRequest, PlanRequest, Planned};
use crate::results::to_diagnose;

/// Plans a flight.
pub fn planned(
    engine: &mut Engine,
    request: PlanRequest,
    progress: &mut Progress<'_>,
) -> Result<Planned, Refused> {
    let PlanRequest { flights, hold_outs, model, times, plan } = request;
    let diagnosed = DiagnoseRequest { flights, hold_outs, model, times };
    let further = further(engine, &diagnosed, progress)?;
    let learned: Vec<&Flight> = diagnosed
        .flights
        .iter()
        .map(|name| engine.flight(name).map(|open| &open.flight))
        .collect::<Result<_, _>>()?;
    let model = parsed(&diagnosed.model)?;
    let planning = Planning::new(&further.planner, &learned, &model, engine.executor);
    let (plan, flown, offers) = match plan {
        Some(plan) => {
            planning.check(&plan).map_err(refused)?;
            progress("simulating the plan", 0, 0);
            let flown = planning.flown(&plan).map_err(refused)?;
            (plan, flown, planning.offers())
        }
        None => {
            let offers =
                planning.weighed_offers(&mut |done, all| progress("flying each manoeuvre", done, all));
            let best = offers.iter().find(|offer| offer.gain.is_some());
            let best = best.ok_or_else(|| {
                refused("no manoeuvre on offer can be flown at the speed and altitude of these flights")
            })?;
            let plan = planning.plan(vec![best.leg]);
            let flown = planning.flown(&plan).map_err(refused)?;
            // A set is worth the search; for what is not excited it takes a browser minutes.
            let found = if flown.outlook.sets.is_empty() {
                None
            } else {
                shortest(&planning, &mut counting("looking for the shortest plan", progress))
            };
            let (plan, flown) = found.map_or((plan, flown), |found| (found.plan, found.flown));
            (plan, flown, offers)
        }
    };
    Ok(Planned {
        segments: flown.segments(&plan),
        reached: flown.reached(),
        duration_s: flown.scenario.duration_s(),
        remarks: planning.around().remarks(),
        plan,
        outlook: flown.outlook,
        scenario: flown.text,
        offers,
    })
}

/// The information in the flights: from a diagnosis already made of them, or from a new one.
fn further(
    engine: &mut Engine,
    request: &DiagnoseRequest,
    progress: &mut Progress<'_>,
) -> Result<Rc<Further>, Refused> {
    let key = engine.diagnosis_key(request)?;
    if let Some(found) = engine.further(&key) {
        return Ok(found);
    }
    if request.flights.is_empty() {
        return Err(refused("no flight to learn from: a plan builds on recorded flights"));
    }
    let learned = to_diagnose(engine, &request.flights, &request.model, &request.times)?;
    let held = to_diagnose(engine, &request.hold_outs, &request.model, &request.times)?;
    let found = diagnose_further(&learned, &held, &mut counting("diagnosing", progress), engine.executor);
    let further =
        found.map_err(refused)?.1.ok_or_else(|| refused("these flights give no basis for a plan"))?;
    Ok(engine.keep_further(key, further))
}
