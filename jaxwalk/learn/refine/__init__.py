"""A trained policy's last layer, searched further by an evolution strategy under graded pushes."""
