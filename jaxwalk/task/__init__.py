"""What is learned and measured: a footstep, decided at each touch-down, and trials made of many."""
