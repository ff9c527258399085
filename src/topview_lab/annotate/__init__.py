"""Ground truth from colour markers: 3D joints from two RGB-D recordings of people who wear markers
on both sides of their joints (Sec. 6.1.2)."""
