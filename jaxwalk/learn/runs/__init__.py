"""What a run leaves behind: its folder, and what it says while it goes on."""
