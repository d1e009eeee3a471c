"""A walk to be seen: films and strips of poses, a page to replay, MuJoCo's viewer to push it in."""
