"""Effects chosen by statsmodels' state-space model, `UnobservedComponents` with regressors.

A sensor's residual in block t is

    y_t = b_0 + sum_j b_j x_jt + w_t + e_t,    w_t = phi w_(t-1) + u_t

with white e and u: regressors, an irregular component, and an AR(1). The AR(1) stands for the wander of
receiver and sensor: errors of seconds to minutes that stay bounded. A random walk as the level would not, and
would absorb slow effects (drift, warming up). For the same reason the level is fixed: the constant b_0.

Effects are chosen forward by BIC of the maximum likelihood:

1. Screen: with the noise's parameters held, the filter's gains turn the residual and every column into
   one-step-ahead errors. Least squares on those is generalised least squares. The column that lowers the
   squares most is tried, and so is the one that ordinary least squares would choose: before a large effect is
   found, the AR(1) may have absorbed it.
2. Refit each of these by maximum likelihood. The coefficients and the noise's scale follow from the other
   two parameters, so the search has two dimensions. The better one is then fitted by statsmodels' own `fit`,
   from there, all parameters free.
3. Stop when BIC does not fall.

A block that is missing is NaN. A block shorter than the others (where a phase ends) counts as a full step.
All blocks are used: there are some hundreds a flight, and a sensor takes about half a second.
"""

import numpy as np
from scipy.linalg import solve_banded
from scipy.optimize import minimize
from statsmodels.tsa.statespace.structural import UnobservedComponents

# Start of the search: half of the variance wanders, with a correlation time of 20 blocks.
FIRST_NOISE = np.array([0.0, np.arctanh(0.95)])
# Bounds: shares of 1e-4 and 1 - 1e-4; correlation times of up to 2000 blocks.
BOUNDS = [(-9.2, 9.2), (0.0, np.arctanh(0.9995))]
MOST_ITERATIONS = 100


def steps(time_s):
    """The blocks' places on an even grid."""
    between = np.diff(time_s)
    whole = np.maximum(1, np.round(between / np.median(between))).astype(int)
    return np.concatenate([[0], np.cumsum(whole)])


class Series:
    """One sensor's residual and candidates on an even grid, and the noise's model."""

    def __init__(self, time_s, residual, columns):
        self.at = steps(time_s)
        self.residual = np.full(self.at[-1] + 1, np.nan)
        self.residual[self.at] = residual
        self.columns = np.zeros((len(self.residual), columns.shape[1] + 1))
        self.columns[:, 0] = 1.0
        self.columns[self.at, 1:] = columns
        self.noise_model = UnobservedComponents(self.residual, irregular=True, autoregressive=1)

    def whitened(self, noise, used):
        """The residual and columns as standardised one-step-ahead errors, for a noise of unit variance, and
        the sum of the errors' log variances."""
        share, phi = 1.0 / (1.0 + np.exp(-noise[0])), np.tanh(noise[1])
        self.noise_model.update([1.0 - share, share * (1.0 - phi**2), phi])
        filtered = self.noise_model.ssm.filter()
        is_there = ~np.isnan(self.residual)
        # statsmodels' gain is that of the next block's prediction: it contains phi.
        gain = np.where(is_there, filtered.kalman_gain[0, 0], 0.0)
        variance = filtered.forecasts_error_cov[0, 0, self.at]
        values = np.column_stack([np.where(is_there, self.residual, 0.0), self.columns[:, used]])
        # The filter's predictions p of all columns at once: p_(t+1) = (phi - gain_t) p_t + gain_t value_t.
        bands = np.ones((2, len(values)))
        bands[1, :-1] = gain[:-1] - phi
        right = np.vstack([np.zeros(values.shape[1]), gain[:-1, None] * values[:-1]])
        errors = values - solve_banded((1, 0), bands, right)
        return errors[self.at] / np.sqrt(variance)[:, None], np.log(variance).sum()

    def regression(self, noise, used):
        """Coefficients, the noise's variance, and the log likelihood: the largest with this noise."""
        errors, logs = self.whitened(noise, used)
        coefficients = np.linalg.lstsq(errors[:, 1:], errors[:, 0], rcond=None)[0]
        count = len(errors)
        variance = np.sum((errors[:, 0] - errors[:, 1:] @ coefficients) ** 2) / count
        return coefficients, variance, -0.5 * (count * (np.log(2.0 * np.pi * variance) + 1.0) + logs)

    def maximum(self, used, starts):
        """The noise that has the largest likelihood with these columns, and that likelihood."""
        def cost(noise):
            return -self.regression(noise, used)[2]
        found = [minimize(cost, start, method="L-BFGS-B", bounds=BOUNDS) for start in starts]
        best = min(found, key=lambda one: one.fun)
        return best.x, -best.fun

    def fit(self, used, noise):
        """statsmodels' fit, begun at this noise: BIC, and whether it has converged."""
        coefficients, variance, _ = self.regression(noise, used)
        share, phi = 1.0 / (1.0 + np.exp(-noise[0])), np.tanh(noise[1])
        start = [variance * (1.0 - share), variance * share * (1.0 - phi**2), phi, *coefficients]
        model = UnobservedComponents(
            self.residual,
            irregular=True,
            autoregressive=1,
            exog=self.columns[:, used],
            mle_regression=True,
        )
        result = model.fit(start, method="bfgs", maxiter=MOST_ITERATIONS, cov_type="none", disp=False)
        return result.bic, bool(result.mle_retvals["converged"])


def best_column(errors, chosen, left):
    """The column of `left` that lowers the squares most beside the chosen ones (and the constant)."""
    basis = np.linalg.qr(errors[:, 1:][:, chosen])[0]
    target = errors[:, 0] - basis @ (basis.T @ errors[:, 0])
    columns = errors[:, 1:][:, left]
    columns = columns - basis @ (basis.T @ columns)
    squares = np.sum(columns**2, axis=0)
    # What the chosen columns already contain gains nothing.
    is_new = squares > 1e-9 * np.sum(errors[:, 1:][:, left] ** 2, axis=0)
    gains = np.where(is_new, (columns.T @ target) ** 2 / np.where(is_new, squares, 1.0), -1.0)
    return left[int(np.argmax(gains))]


def stepwise(time_s, residual, columns, groups, most):
    """Chooses columns forward by BIC; of each group (an effect's time constants) one at most.

    Returns their indices, the number of statsmodels' fits, and how many of these have not converged."""
    series = Series(time_s, residual, columns)
    every = list(range(columns.shape[1] + 1))
    chosen = [0]
    noise, _ = series.maximum(chosen, [FIRST_NOISE])
    best, converged = series.fit(chosen, noise)
    fits, unconverged = 1, int(not converged)
    while len(chosen) <= most:
        taken = {groups[column - 1] for column in chosen[1:]}
        left = [column for column in every[1:] if groups[column - 1] not in taken]
        if not left:
            break
        held = best_column(series.whitened(noise, every)[0], chosen, left)
        plain = np.column_stack([series.residual, series.columns])[series.at]
        tried = []
        for column in sorted({held, best_column(plain, chosen, left)}):
            own_noise, likelihood = series.maximum([*chosen, column], [noise, FIRST_NOISE])
            tried.append((likelihood, column, own_noise))
        _, column, noise = max(tried, key=lambda one: one[0])
        bic, converged = series.fit([*chosen, column], noise)
        fits, unconverged = fits + 1, unconverged + int(not converged)
        # Comparing with `not` ends the search at a BIC that is not a number, too.
        if not bic < best:
            break
        best = bic
        chosen.append(column)
    return [column - 1 for column in chosen[1:]], fits, unconverged
