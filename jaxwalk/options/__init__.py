"""Options from the command line: their types, checks that commands share, and lines to be typed again."""
