"""The paper's experiments: trainings on simulated frames, on real ones, and on both, and what they are worth."""
