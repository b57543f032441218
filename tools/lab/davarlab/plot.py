"""Pictures of a comparison."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from scipy import stats  # noqa: E402


def whole_record(comparison):
    stop = max(cell.stop_s for cell in comparison.cells)
    return [cell for cell in comparison.cells if cell.stop_s - cell.start_s > 0.99 * stop]


def draw_deviation(axes, comparison):
    cells = whole_record(comparison)
    tau = np.array([cell.tau_s for cell in cells])
    model = np.array([cell.model_dps for cell in cells])
    freedom = np.array([cell.freedom for cell in cells])
    low, high = (model * np.sqrt(stats.chi2.ppf(p, freedom) / freedom) for p in (0.025, 0.975))
    axes.fill_between(tau, low, high, color="tab:blue", alpha=0.2, label="95 % of recordings, were the model true")
    axes.loglog(tau, model, color="tab:blue", label="model")
    axes.loglog(tau, [cell.measured_dps for cell in cells], "k.", label="measured")
    axes.set(xlabel="tau [s]", ylabel="Allan deviation [deg/s]")
    axes.legend()


def draw_map(axes, comparison):
    shortest = min(cell.stop_s - cell.start_s for cell in comparison.cells)
    cells = [cell for cell in comparison.cells if cell.stop_s - cell.start_s < 1.01 * shortest]
    time, tau = sorted({cell.start_s for cell in cells}), sorted({cell.tau_s for cell in cells})
    z = np.full((len(tau), len(time)), np.nan)
    for cell in cells:
        z[tau.index(cell.tau_s), time.index(cell.start_s)] = cell.z
    mesh = axes.pcolormesh(np.append(time, time[-1] + shortest), np.geomspace(tau[0], 2 * tau[-1], len(tau) + 1), z,
                           cmap="RdBu_r", vmin=-5, vmax=5)
    axes.set(yscale="log", xlabel="time [s]", ylabel="tau [s]", title="measured against model, standard deviations")
    axes.figure.colorbar(mesh, ax=axes)


def draw_spectrum(axes, comparison):
    f, ratio, counts = comparison.spectrum
    spread = 2 * np.sqrt(2 / np.maximum(counts, 1))
    axes.fill_between(f, np.maximum(1 - spread, 1e-2), 1 + spread, color="tab:blue", alpha=0.2)
    axes.loglog(f, np.maximum(ratio, 1e-2), "k.")
    axes.set(xlabel="frequency [Hz]", ylabel="residual spectrum over model")


def draw(comparison, path):
    """Allan deviation, failure map and residual spectrum in one PNG."""
    figure, axes = plt.subplots(3, 1, figsize=(9, 12), layout="constrained")
    draw_deviation(axes[0], comparison)
    draw_map(axes[1], comparison)
    draw_spectrum(axes[2], comparison)
    axes[0].set_title(f"{', '.join(comparison.effects)}: error {comparison.error:.3f}, floor {comparison.error_floor:.3f}, "
                      f"p = {comparison.p_value:.2g}")
    figure.savefig(path, dpi=100)
    plt.close(figure)
