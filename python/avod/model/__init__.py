"""Networks: AVOD-FPN, the center detector, and what both share."""
