//! Literal expressions, whose size is bounded by the source.

use minijinja::machinery::ast::{Expr, UnaryOpKind};

/// Whether an expression is a literal, or a list or map of literals.
pub fn is_literal(expr: &Expr<'_>) -> bool {
    match expr {
        Expr::Const(_) => true,
        Expr::List(list) => list.items.iter().all(is_literal),
        Expr::Tuple(tuple) => tuple.items.iter().all(is_literal),
        Expr::Map(map) => map.keys.iter().chain(&map.values).all(is_literal),
        Expr::UnaryOp(unary) => {
            matches!(unary.op, UnaryOpKind::Neg) && matches!(unary.expr, Expr::Const(_))
        }
        _ => false,
    }
}

/// Whether it is a literal that costs next to nothing: a number, a word.
pub fn is_short(expr: &Expr<'_>) -> bool {
    match expr {
        Expr::Const(literal) => literal.value.as_str().is_none_or(|text| text.len() <= 64),
        Expr::UnaryOp(_) => is_literal(expr),
        _ => false,
    }
}
