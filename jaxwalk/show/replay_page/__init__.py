"""Watching a policy: a page that replays recorded walks, and MuJoCo's viewer with pushes at a key."""
