"""Symbolic regression and sparse regression on the block means that Pylon's search for laws uses.

`laws.py FOLDER` reads what `laws --dump FOLDER` wrote: for every trial the block means of the flight that is
learned from (SEED-0.csv) and of the next one (SEED-1.csv), with what the hidden law adds (`true_m`, which
only the score uses). The target is the barometer's residual.

* gplearn: genetic programming over all signals, fitness the correlation, then scale and offset by least squares;
* PySINDy: polynomials of the second degree of all signals (standardised), sequentially thresholded least squares, the threshold by
  cross-validation.

Neither models the wander of receiver and barometer. So that a null flight can end without a law, a method
proposes one only if it lowers the error of held-out stretches of the flight (five, each held out in turn, in
order of time; the law's coefficients are fitted to the others).
"""

import sys
import warnings
from pathlib import Path

import numpy as np
import pysindy
from gplearn.genetic import SymbolicRegressor
from joblib import Parallel, delayed

POPULATION, GENERATIONS = 1000, 20
STRETCHES = 5
PREDICTS = 0.95


def read(file):
    table = np.genfromtxt(file, delimiter=",", names=True)
    names = [name for name in table.dtype.names if name not in ("time_s", "free", "residual_m", "true_m")]
    signals = np.column_stack([table[name] for name in names])
    return names, signals, table["residual_m"], table["true_m"], table["free"] > 0.5


def stretches(rows):
    return np.arange(rows) * STRETCHES // rows


def line(column, residual):
    design = np.column_stack([np.ones(len(column)), column])
    return np.linalg.lstsq(design, residual, rcond=None)[0]


def lowers(design_of, residual):
    """Whether the law lowers the error of held-out stretches; `design_of(used)` fits on the used ones."""
    of = stretches(len(residual))
    error = np.empty_like(residual)
    null = np.empty_like(residual)
    for stretch in range(STRETCHES):
        used = of != stretch
        error[~used] = (residual - design_of(used))[~used]
        null[~used] = (residual - residual[used].mean())[~used]
    return np.sum(error**2) < np.sum(null**2)


def genetic(signals, residual, following, seed):
    scale = np.abs(signals).max(axis=0)
    program = SymbolicRegressor(
        population_size=POPULATION,
        generations=GENERATIONS,
        function_set=("add", "sub", "mul", "div", "sqrt", "abs", "min", "max", "sin", "cos"),
        metric="pearson",
        parsimony_coefficient=0.002,
        max_samples=0.9,
        random_state=seed,
    )
    program.fit(signals / scale, residual)
    column = program.predict(signals / scale)

    def fitted(used):
        offset, slope = line(column[used], residual[used])
        return offset + slope * column

    if not lowers(fitted, residual):
        return None
    return line(column, residual)[1] * program.predict(following / scale)


def sparse(signals, residual, following, _):
    mean, spread = signals.mean(axis=0), signals.std(axis=0)
    library = pysindy.PolynomialLibrary(degree=2, include_bias=False)
    columns = np.asarray(library.fit_transform((signals - mean) / spread))
    next_columns = np.asarray(library.transform((following - mean) / spread))
    centre = columns.mean(axis=0)
    columns, next_columns = columns - centre, next_columns - centre

    def fit(used, threshold):
        optimizer = pysindy.STLSQ(threshold=threshold, alpha=1.0)
        optimizer.fit(columns[used], (residual[used] - residual[used].mean()).reshape(-1, 1))
        return np.asarray(optimizer.coef_).ravel()

    of = stretches(len(residual))
    best = (np.inf, None)
    for threshold in np.geomspace(0.02, 2.0, 8) * residual.std():
        error = 0.0
        for stretch in range(STRETCHES):
            used = of != stretch
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                left = residual - residual[used].mean() - columns @ fit(used, threshold)
            error += np.sum(left[~used] ** 2)
        best = min(best, (error, threshold))
    threshold = best[1]
    null = sum(
        np.sum((residual[of == k] - residual[of != k].mean()) ** 2) for k in range(STRETCHES)
    )
    if best[0] >= null:
        return None
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        coefficients = fit(np.ones(len(residual), bool), threshold)
    return next_columns @ coefficients if np.any(coefficients) else None


METHODS = {"gplearn": genetic, "PySINDy": sparse}


def trial(folder, seed):
    names, signals, residual, truth, _ = read(folder / f"{seed}-0.csv")
    next_names, following, _, next_truth, free = read(folder / f"{seed}-1.csv")
    following = following[:, [next_names.index(name) for name in names]]
    is_null = np.abs(truth).max() == 0.0
    found = {}
    for name, method in METHODS.items():
        law = method(signals, residual, following, seed)
        if law is None:
            found[name] = (is_null, False, False, False)
            continue
        about = law - (law[~free].mean() if (~free).any() else law.mean())
        true = next_truth - (next_truth[~free].mean() if (~free).any() else next_truth.mean())
        before, after = np.sum(true[free] ** 2), np.sum((true - about)[free] ** 2)
        spread = np.std(law[free]) * np.std(next_truth[free])
        correlation = 0.0 if spread == 0.0 else np.corrcoef(law[free], next_truth[free])[0, 1]
        found[name] = (is_null, True, bool(correlation >= PREDICTS), bool(after > before))
    return found


def share(hits, of):
    return f"{hits:>3} of {of:<3}" + (f" {100 * hits / of:5.1f} %" if of else "")


def main():
    folder = Path(sys.argv[1])
    seeds = sorted(int(file.stem.split("-")[0]) for file in folder.glob("*-1.csv"))
    results = Parallel(n_jobs=-1)(delayed(trial)(folder, seed) for seed in seeds)
    print(f"gplearn (population {POPULATION}, {GENERATIONS} generations) and PySINDy on the block means of {len(seeds)} of these trials")
    print(f"{'':<56}" + "".join(f"{name:>20}" for name in METHODS))

    def row(what, count):
        print(f"{what:<56}" + "".join(f"{share(*count([r[name] for r in results])):>20}" for name in METHODS))

    hidden = lambda trials: [t for t in trials if not t[0]]
    null = lambda trials: [t for t in trials if t[0]]
    row("its law predicts the hidden one on the next flight", lambda t: (sum(x[2] for x in hidden(t)), len(hidden(t))))
    row("it has no law of a hidden one", lambda t: (sum(not x[1] for x in hidden(t)), len(hidden(t))))
    row("null flights of which it has a law", lambda t: (sum(x[1] for x in null(t)), len(null(t))))
    row("its law makes the next flight worse, of all trials", lambda t: (sum(x[3] for x in t), len(t)))


main()
