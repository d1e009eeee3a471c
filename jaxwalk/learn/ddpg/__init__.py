"""The learner: deep deterministic policy gradients, with TD3 as a switch."""
