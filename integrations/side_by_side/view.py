"""The view of test_three.py, in a world whose up is +z."""

SIZE = 256
EYE = (0.9, -3.0, 1.4)
LIGHT = (1.0, -1.5, 2.0)  # toward it; a white diffuse surface that faces it has the radiance 1
FIELD_OF_VIEW = 35.0  # degrees
