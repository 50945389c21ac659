(groove of a seal: radius 70 mm, 4 mm deep, in two rounds; z 30 is the face)
G21 G17 G90
G0 X70 Y0 Z50
G1 Z28 F1500
G2 X70 Y0 I-70 J0 F1500
G1 Z26 F1500
G2 X70 Y0 I-70 J0 F1500
G0 Z50
M2
