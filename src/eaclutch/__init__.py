"""eaclutch: calibrate electroadhesive clutches and diagnose their sim-to-real gap."""
