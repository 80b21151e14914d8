"""Learns `reach` with the cross-entropy method: the gain with which the goal of the TCP
follows the remaining error. Some minutes on two cores; prints and plots the curve.

python train_reach.py [--generations 14] [--plot reach.svg]
"""

import argparse

import gymnasium
import numpy as np

import robocell.gym

CANDIDATES = 24
ELITE = 5
STEPS = 40
#: Columns of the observation: the TCP, and the goal at its end.
TCP, GOAL = slice(14, 17), slice(-3, None)


def act(parameters: np.ndarray, observations: np.ndarray) -> np.ndarray:
    """A linear policy of the remaining error: 3 x 3 gains, and a bias, for the translation."""
    missing = observations[:, GOAL] - observations[:, TCP]
    gains = parameters[:, :9].reshape(-1, 3, 3)
    actions = np.zeros((len(observations), 7), dtype=np.float32)
    actions[:, :3] = np.einsum("nij,nj->ni", gains, 10.0 * missing) + parameters[:, 9:]
    return np.clip(actions, -1.0, 1.0)


def evaluate(envs: gymnasium.vector.VectorEnv, parameters: np.ndarray, seed: int) -> np.ndarray:
    """Return and success of each row of parameters in one episode of the same goal."""
    observations, _ = envs.reset(seed=[seed] * len(parameters))
    returns = np.zeros(len(parameters))
    success = np.zeros(len(parameters))
    for _ in range(STEPS):
        running = success == 0.0
        observations, rewards, terminated, _, _ = envs.step(act(parameters, observations))
        # Slow ways to the goal are worth less.
        returns += running * (rewards - 0.01)
        success[running & terminated] = 1.0
        if success.all():
            break
    return np.stack([returns, success], axis=1)


def train(generations: int, seed: int = 0) -> list[dict[str, float]]:
    """The curve: mean return, and the share of goals that the mean policy reaches."""
    rng = np.random.default_rng(seed)
    mean, deviation = np.zeros(12), np.array([1.0] * 9 + [0.2] * 3)
    curve = []
    envs = gymnasium.make_vec(
        robocell.gym.IDS["reach"], num_envs=CANDIDATES, vectorization_mode="vector_entry_point"
    )
    for generation in range(generations):
        parameters = mean + deviation * rng.normal(size=(CANDIDATES, 12))
        # The first is the mean itself: its success is the curve.
        parameters[0] = mean
        seeds = rng.integers(1 << 31, size=4)
        scores = np.mean([evaluate(envs, parameters, int(s)) for s in seeds], axis=0)
        elite = parameters[np.argsort(scores[:, 0])[-ELITE:]]
        mean, deviation = elite.mean(axis=0), elite.std(axis=0) + 0.05
        curve.append(
            {
                "generation": generation,
                "return": float(scores[:, 0].mean()),
                "success": float(scores[:, 1].mean()),
                "success_of_mean": float(scores[0, 1]),
            }
        )
        print("  ".join(f"{key} {value:.3g}" for key, value in curve[-1].items()), flush=True)
    return curve


def plot(curve: list[dict[str, float]], file: str) -> None:
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(7, 3.5))
    axes.plot([row["return"] for row in curve], label="return, mean of the generation")
    axes.plot([row["success"] for row in curve], label="share of goals reached")
    axes.set(xlabel="generation", title="reach, cross-entropy method")
    axes.legend()
    figure.tight_layout()
    figure.savefig(file)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--generations", type=int, default=14)
    parser.add_argument("--plot", metavar="FILE")
    words = parser.parse_args()
    learned = train(words.generations)
    if words.plot:
        plot(learned, words.plot)
