"""Commonly used methods, on the same residuals as Pylon's diagnosis.

`compare.py FOLDER` reads what `blind --dump FOLDER` wrote: `trials.json` (what was hidden, and what Pylon
reported) and a table of block means per trial. Each sensor in free flight is regressed by itself on every
candidate and a bias:

* ordinary least squares, forward stepwise by BIC (statsmodels);
* the LASSO, its penalty by five-fold cross-validation (scikit-learn); an effect with a coefficient
  counts as found.

A time constant is chosen from the same grid as Pylon's; its columns count as one effect. Where two effects have the
same regressor on a sensor, naming either counts as right.
"""

import json
import sys
import warnings
from pathlib import Path

import numpy as np
import pandas as pd
import statsmodels.api as sm
from joblib import Parallel, delayed
from sklearn.linear_model import LassoCV
from sklearn.preprocessing import StandardScaler

FREE_SENSORS = ["baro", "imu_slave"]
MOST_EFFECTS = 20


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


def try_methods(folder, trial):
    warnings.simplefilter("ignore")
    table = pd.read_csv(folder / f"{trial['seed']}.csv")
    found = {"OLS, BIC stepwise": set(), "LASSO, cross-validated": set()}
    for sensor in FREE_SENSORS:
        rows = table[table["sensor"] == sensor].reset_index(drop=True)
        if len(rows) < 20 or not candidates(rows):
            continue
        truth = set(trial["truth"])
        found["OLS, BIC stepwise"] |= in_favour(bic_stepwise(rows), rows, truth)
        found["LASSO, cross-validated"] |= in_favour(lasso(rows), rows, truth)
    return found


def share(hits):
    hits = list(hits)
    return f"{100.0 * sum(hits) / max(len(hits), 1):5.1f} % ({sum(hits)} of {len(hits)})"


def rates(trials, found):
    """Rates of one method; `found` has one set of effects per trial."""
    def counts(trial):
        return trial["strongest"] is not None
    pairs = list(zip(trials, found))
    return [
        share(trial["strongest"] in names for trial, names in pairs if counts(trial)),
        share(bool(names - set(trial["truth"])) for trial, names in pairs),
        share(bool(names) for trial, names in pairs if trial["is_null"]),
        f"{sum(len(names) for names in found) / max(len(found), 1):.1f}",
    ]


def main():
    if len(sys.argv) != 2:
        sys.exit("usage: compare.py FOLDER (written by `blind --dump FOLDER`)")
    folder = Path(sys.argv[1])
    trials = json.loads((folder / "trials.json").read_text())
    answers = Parallel(n_jobs=-1)(delayed(try_methods)(folder, trial) for trial in trials)
    methods = {"Pylon": [set(trial["identified"]) for trial in trials]}
    for answer in answers:
        for name, names in answer.items():
            methods.setdefault(name, []).append(names)
    print("| method | strongest effect identified | a wrong effect identified | anything identified on a null flight | effects named a flight |")
    print("|---|---|---|---|---|")
    for name, found in methods.items():
        print(f"| {name} | {' | '.join(rates(trials, found))} |")
    in_set = share(trial["is_held"] for trial in trials if trial["strongest"] is not None)
    print(f"\nPylon names the strongest effect, or a set that holds it, in {in_set}. The others have no word for \"one of these\".")


if __name__ == "__main__":
    main()
