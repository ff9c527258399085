"""Detectors of heads (later: faces, hands, skin), each behind one small protocol."""
