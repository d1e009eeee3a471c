"""The compliant controllers: legs that yield, a push-off before the other foot lands, steps that can be
changed while they are under way. All joints are moved by torques."""
