"""Policies: what a file of one holds, those that go by a name, and where a result comes from."""
