"""The page on which a walker walks and can be pushed: it is simulated in the browser."""
