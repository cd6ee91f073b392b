"""Commonly used methods, on the same residuals as Pylon's diagnosis.

`compare.py FOLDER [--earlier PYLON]` reads what `blind --dump FOLDER` wrote: `trials.json` (what was hidden,
and what Pylon reported), and for each trial a table of block means and the whole flight. Each sensor in free
flight is regressed by itself on every candidate and a bias:

* ordinary least squares, forward stepwise by BIC (statsmodels);
* the LASSO, its penalty by five-fold cross-validation (scikit-learn); an effect with a coefficient
  counts as found;
* a state-space model with regressors, forward stepwise by BIC (statsmodels; `state_space.py`).

`--earlier` is the `pylon` of another commit. It diagnoses the whole flights. One that it refuses counts as a
flight on which it identifies nothing, and is reported.

A time constant is chosen from the same grid as Pylon's; its columns count as one effect. Where two effects
have the same regressor on a sensor, naming either counts as right.
"""

import argparse
import json
import subprocess
import warnings
from pathlib import Path

import numpy as np
import pandas as pd
import statsmodels.api as sm
from joblib import Parallel, delayed
from sklearn.linear_model import LassoCV
from sklearn.preprocessing import StandardScaler

import state_space

FREE_SENSORS = ["baro", "imu_slave"]
MOST_EFFECTS = 20
OLS, LASSO, STATE_SPACE = "OLS, BIC stepwise", "LASSO, cross-validated", "state space, BIC stepwise"
# The longest that an earlier Pylon may take for a flight, s.
PATIENCE_S = 600.0


def effect(column):
    return column.split("@")[0]


def candidates(rows):
    """The columns that vary on these rows."""
    columns = rows.columns[4:]
    return [column for column in columns if rows[column].std() > 1e-9]


def in_favour(names, rows, truth):
    """Replaces an effect by a true one whose regressor is the same on these rows.

    No method of one sensor can distinguish them: for example a late receiver and a late barometer."""
    columns = candidates(rows)
    correlation = np.abs(np.atleast_2d(np.corrcoef(rows[columns].to_numpy(), rowvar=False)))
    result = set()
    for name in names:
        own = [k for k, column in enumerate(columns) if column == name]
        same = {effect(columns[j]) for k in own for j in range(len(columns)) if correlation[k, j] > 0.9999}
        result.add(next(iter(sorted(same & truth)), effect(name)))
    return result


def bic_stepwise(rows):
    residual = rows["residual_m"].to_numpy()
    columns = {column: rows[column].to_numpy() for column in candidates(rows)}
    # Scaled, so that the solver treats a metre and a second squared alike.
    columns = {column: values / values.std() for column, values in columns.items()}
    chosen = []
    design = np.ones((len(residual), 1))
    best = sm.OLS(residual, design).fit().bic
    while len(chosen) < MOST_EFFECTS:
        left = [c for c in columns if effect(c) not in {effect(other) for other in chosen}]
        tried = [(sm.OLS(residual, np.column_stack([design, columns[c]])).fit().bic, c) for c in left]
        if not tried or min(tried)[0] >= best:
            break
        best, column = min(tried)
        chosen.append(column)
        design = np.column_stack([design, columns[column]])
    return chosen


def lasso(rows):
    columns = candidates(rows)
    design = StandardScaler().fit_transform(rows[columns].to_numpy())
    fit = LassoCV(cv=5, max_iter=5000).fit(design, rows["residual_m"].to_numpy())
    return [column for column, coefficient in zip(columns, fit.coef_) if coefficient != 0.0]


def stepwise_state_space(rows):
    """The effects, the number of fits, and how many of these have not converged."""
    columns = candidates(rows)
    values = rows[columns].to_numpy()
    chosen, fits, unconverged = state_space.stepwise(
        rows["time_s"].to_numpy(),
        rows["residual_m"].to_numpy(),
        values / values.std(axis=0),
        [effect(column) for column in columns],
        MOST_EFFECTS,
    )
    return [columns[k] for k in chosen], fits, unconverged


def diagnose(pylon, flight):
    """What another build of Pylon identifies, and the members of its sets; None if it refuses the flight."""
    try:
        run = subprocess.run(
            [pylon, "diagnose", flight, "--json"], capture_output=True, timeout=PATIENCE_S, check=False
        )
        sensors = json.loads(run.stdout)["sensors"].values()
    except (subprocess.TimeoutExpired, ValueError, KeyError, TypeError):
        return None
    missing = {name for sensor in sensors for name in sensor["missing"]}
    in_sets = {name for sensor in sensors for names in sensor["indistinguishable"] for name in names}
    return missing, in_sets


def try_methods(folder, trial, earlier):
    warnings.simplefilter("ignore")
    table = pd.read_csv(folder / f"{trial['seed']}.csv")
    found = {OLS: set(), LASSO: set(), STATE_SPACE: set()}
    fits, unconverged = 0, 0
    for sensor in FREE_SENSORS:
        rows = table[table["sensor"] == sensor].reset_index(drop=True)
        if len(rows) < 20 or not candidates(rows):
            continue
        truth = set(trial["truth"])
        found[OLS] |= in_favour(bic_stepwise(rows), rows, truth)
        found[LASSO] |= in_favour(lasso(rows), rows, truth)
        chosen, own_fits, own_unconverged = stepwise_state_space(rows)
        found[STATE_SPACE] |= in_favour(chosen, rows, truth)
        fits, unconverged = fits + own_fits, unconverged + own_unconverged
    before = diagnose(earlier, folder / f"{trial['seed']}.flight.csv") if earlier else None
    return {"found": found, "fits": fits, "unconverged": unconverged, "before": before}


def share(hits):
    hits = list(hits)
    return f"{100.0 * sum(hits) / max(len(hits), 1):5.1f} % ({sum(hits)} of {len(hits)})"


def counts(trial):
    return trial["strongest"] is not None


def rates(trials, found, held):
    """Rates of one method; `found` has one set of effects per trial. `held` says for each trial whether the
    strongest effect is identified or in a set; None for a method without sets."""
    pairs = list(zip(trials, found))
    return [
        share(trial["strongest"] in names for trial, names in pairs if counts(trial)),
        share(hit for trial, hit in zip(trials, held) if counts(trial)) if held else "no sets",
        share(bool(names - set(trial["truth"])) for trial, names in pairs),
        share(bool(names) for trial, names in pairs if trial["is_null"]),
        f"{sum(len(names) for names in found) / max(len(found), 1):.1f}",
    ]


def print_row(name, cells):
    print(f"| {name} | {' | '.join(cells)} |")


def main():
    parser = argparse.ArgumentParser(description="Commonly used methods beside Pylon's diagnosis")
    parser.add_argument("folder", type=Path, help="written by `blind --dump FOLDER`")
    parser.add_argument("--earlier", metavar="PYLON", help="the program `pylon` of another commit")
    arguments = parser.parse_args()
    trials = json.loads((arguments.folder / "trials.json").read_text())
    answers = Parallel(n_jobs=-1)(
        delayed(try_methods)(arguments.folder, trial, arguments.earlier) for trial in trials
    )
    columns = ["strongest effect identified", "identified or in a set", "a wrong effect identified"]
    columns += ["anything identified on a null flight", "effects named a flight"]
    print_row("method", columns)
    print(f"|{'---|' * (len(columns) + 1)}")
    held = [trial["is_held"] for trial in trials]
    print_row("Pylon", rates(trials, [set(trial["identified"]) for trial in trials], held))
    if arguments.earlier:
        before = [answer["before"] or (set(), set()) for answer in answers]
        held = [trial["strongest"] in missing | in_sets for trial, (missing, in_sets) in zip(trials, before)]
        print_row("Pylon, earlier", rates(trials, [missing for missing, _ in before], held))
    for method in [OLS, LASSO, STATE_SPACE]:
        print_row(method, rates(trials, [answer["found"][method] for answer in answers], None))
    fits, unconverged = (sum(answer[key] for answer in answers) for key in ("fits", "unconverged"))
    print(f"\nOf {fits} state-space fits, {unconverged} did not converge; they count as they ended.")
    if arguments.earlier:
        refused = [str(trial["seed"]) for trial, answer in zip(trials, answers) if answer["before"] is None]
        names = f": {', '.join(refused)}" if refused else ""
        print(f"Of {len(trials)} flights, the earlier Pylon refused {len(refused)}{names}.")


if __name__ == "__main__":
    main()
