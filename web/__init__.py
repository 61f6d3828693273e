"""What the browser sees: the pages, their static files, and the 3D scene behind a proxy on the same port."""
