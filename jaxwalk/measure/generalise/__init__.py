"""How far a frozen policy generalises: other bodies, loads, floors, sensors and speeds.

circumstances -> evaluate (for each) -> picture
"""
