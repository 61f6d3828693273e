"""The mission in 3D. The only package that imports viser; one file per layer of the scene."""
